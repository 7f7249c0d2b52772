//! Arms of a comparison: each is a name for a few settings, laid over the scenario as `--set` would.
//!
//! So an arm has no code of its own, and whatever the scenario says about other keys holds for all of them alike: a
//! step size that it gives is shared, one that it leaves out takes the default of the arm's learner. The built-in arms
//! are [`BUILT_IN_ARMS`]; a scenario adds its own, each of which may begin as another one:
//!
//! ```toml
//! [arms.steep]
//! base = "gcn"
//! "shaping.scale_factor" = 8.0
//! ```

use super::built_in_arms::BUILT_IN_ARMS;
use super::document::{Document, Setting};
use super::error::{BrokenRule, Choices, Location, ScenarioError};
use super::examination::Examination;
use super::{Scenario, Worlds, check_name};
use crate::shaping::PotentialKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Sections that an arm may set.
const SECTIONS: [&str; 7] = [
    "spectral",
    "deepwalk",
    "gcn",
    "shaping",
    "exploration",
    "agent",
    "schedule",
];

/// The table `[arms.NAME]`: an arm of a scenario's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ArmParams {
    /// The arm that it begins as, built in or of this scenario; the scenario as it stands, if none is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// What it is, in one line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// "section.key" = value, of every section but `env` and `run`: all arms see the same world for as long.
    #[serde(flatten)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub settings: BTreeMap<String, toml::Value>,
}

/// An arm laid over a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Its name.
    pub name: String,
    /// `section.key=value`, laid over the file and over `--set`.
    pub settings: Vec<String>,
    /// What came out, complete and checked; its worlds are those of the scenario that it is laid over.
    pub scenario: Scenario,
}

impl Arm {
    /// The arm that `settings` laid over `document` amount to.
    fn of(name: &str, settings: Vec<Setting>, document: Document) -> Result<Self, ScenarioError> {
        let amend = amend(&settings);
        let mut examined = Examination::of(document, &settings, &amend);
        examined.sections();
        let scenario = examined.finish()?;
        Ok(Arm {
            name: name.to_owned(),
            settings: settings.into_iter().map(|setting| setting.text).collect(),
            scenario,
        })
    }
}

/// The document that arms are laid over: the file with the assignments of the command line.
fn laid(path: &Path, text: &str, settings: &[Setting]) -> Result<Document, ScenarioError> {
    let mut document = Document::new(path, text.to_owned())?;
    let mut settings = settings.iter();
    let laid = settings.try_for_each(|setting| document.lay(setting));
    laid.map(|()| document).map_err(|mistake| ScenarioError {
        file: path.to_owned(),
        scenario: None,
        mistakes: vec![mistake],
    })
}

/// Examines every arm of the scenario's own. The file of φ that one of them names is read for `worlds`, if there are any.
pub(super) fn examine(examined: &mut Examination<'_>, mut worlds: Option<&mut Worlds>) {
    let own = examined.scenario().map(|scenario| scenario.arms.keys());
    let names: Vec<String> = own.into_iter().flatten().cloned().collect();
    for name in names {
        let checked = examined.until_sound(|scenario| scenario.check_arm(&name));
        let scenario = examined.scenario().filter(|s| s.arms.contains_key(&name));
        let (Some(()), Some(scenario)) = (checked, scenario) else {
            continue;
        };
        let mut settings = Vec::new();
        scenario.collect(&name, examined.document(), &mut settings);
        let arm = examined.also(&settings, &amend(&settings));
        let read = match (arm, &mut worlds) {
            (Some(arm), Some(worlds)) => worlds.read_potential(&arm.shaping),
            _ => Ok(()),
        };
        if let Err(broken) = read {
            examined.note(BrokenRule {
                key: format!("arms.{name}.{}", broken.key),
                ..broken
            });
        }
    }
}

/// What makes a scenario over which `settings` are laid an arm.
fn amend(settings: &[Setting]) -> impl Fn(&mut Scenario) + use<> {
    let mut settings = settings.iter();
    let names_file = settings.any(|setting| setting.text.starts_with("shaping.file"));
    move |scenario| {
        scenario.arms.clear(); // what others there are is no business of this one
        if scenario.shaping.potential != PotentialKind::File && !names_file {
            scenario.shaping.file = None; // it was for the potential that the arm has replaced
        }
    }
}

impl ArmParams {
    /// Writes tables of settings as keys with dots.
    pub(super) fn flatten(&mut self) {
        let mut flat = BTreeMap::new();
        for (key, value) in std::mem::take(&mut self.settings) {
            flatten_into(&mut flat, key, value);
        }
        self.settings = flat;
    }
}

/// Puts a value into `flat`, those of a table by their keys with dots.
pub(super) fn flatten_into(
    flat: &mut BTreeMap<String, toml::Value>,
    key: String,
    value: toml::Value,
) {
    match value {
        toml::Value::Table(table) => {
            for (inner, value) in table {
                flatten_into(flat, format!("{key}.{inner}"), value);
            }
        }
        value => {
            flat.insert(key, value);
        }
    }
}

impl Scenario {
    /// Every arm there is, with what it is in one line: the scenario's own ones first.
    pub fn arm_names(&self) -> impl Iterator<Item = (&str, &str)> {
        let own = self.arms.iter();
        let own = own.map(|(name, arm)| (name.as_str(), arm.about.as_deref().unwrap_or_default()));
        own.chain(BUILT_IN_ARMS.iter().map(|arm| (arm.name, arm.about)))
    }

    /// Lays the arm `name` over this scenario: `text` is its file at `path`, and `sets` the assignments over it.
    /// None if there is no such arm.
    ///
    /// # Errors
    /// If the arm does not go with the scenario, with the setting to blame.
    pub fn lay_arm(
        &self,
        name: &str,
        path: &Path,
        text: &str,
        sets: &[String],
    ) -> Result<Option<Arm>, ScenarioError> {
        self.lay_arm_over(name, path, text, &Setting::typed(sets))
    }

    /// The same over settings that know their places.
    pub(super) fn lay_arm_over(
        &self,
        name: &str,
        path: &Path,
        text: &str,
        below: &[Setting],
    ) -> Result<Option<Arm>, ScenarioError> {
        if self.arm_names().all(|(known, _)| known != name) {
            return Ok(None);
        }
        let document = laid(path, text, below)?;
        let mut settings = Vec::new();
        self.collect(name, &document, &mut settings);
        Arm::of(name, settings, document).map(Some)
    }

    /// Lays settings over the scenario under a name of their own; the rest as [`Scenario::lay_arm`].
    ///
    /// # Errors
    /// If they do not go with the scenario.
    pub fn lay_settings(
        name: &str,
        settings: Vec<String>,
        path: &Path,
        text: &str,
        sets: &[String],
    ) -> Result<Arm, ScenarioError> {
        let settings = settings.into_iter().map(|text| Setting {
            place: Location::Arm(name.to_owned(), text.clone()),
            text,
        });
        let document = laid(path, text, &Setting::typed(sets))?;
        Arm::of(name, settings.collect(), document)
    }

    /// The settings of `name`, those of its base first.
    fn collect(&self, name: &str, document: &Document, settings: &mut Vec<Setting>) {
        if let Some(arm) = BUILT_IN_ARMS.iter().find(|arm| arm.name == name) {
            settings.extend(arm.settings.iter().map(|&text| Setting {
                text: text.to_owned(),
                place: Location::Arm(name.to_owned(), text.to_owned()),
            }));
            return;
        }
        let Some(arm) = self.arms.get(name) else {
            return;
        };
        if let Some(base) = &arm.base {
            self.collect(base, document, settings);
        }
        settings.extend(arm.settings.iter().map(|(key, value)| Setting {
            text: format!("{key}={value}"),
            place: document.place_of(&format!("arms.{name}.{key}")),
        }));
    }

    /// Whether the table says what an arm may say; its values are judged when it is laid.
    fn check_arm(&self, name: &str) -> Result<(), BrokenRule> {
        let key = format!("arms.{name}");
        check_name(name).map_err(|broken| BrokenRule::new(&key, broken.message))?;
        if BUILT_IN_ARMS.iter().any(|built_in| built_in.name == name) {
            let message = format!("{key}: `{name}` is built in; call yours something else");
            return Err(BrokenRule::new(key, message));
        }
        let settings = self.arms.get(name).map(|arm| arm.settings.keys());
        for setting in settings.into_iter().flatten() {
            let section = setting.split('.').next().unwrap_or_default();
            if setting == section || ["env", "run"].contains(&section) {
                return Err(stray(&key, setting, section));
            }
        }
        self.check_bases(name)
    }

    /// Follows the bases of `name` to an arm without, or one that is built in.
    fn check_bases(&self, name: &str) -> Result<(), BrokenRule> {
        let mut passed = vec![name];
        while let Some(base) = self.arms.get(passed[passed.len() - 1]).map(|arm| &arm.base) {
            let Some(base) = base.as_deref() else { break };
            let key = format!("arms.{}.base", passed[passed.len() - 1]);
            if passed.contains(&base) {
                let way = passed.join(", ");
                let message = format!("{key} = \"{base}\" leads back to itself: {way}, {base}");
                return Err(BrokenRule::new(key, message));
            }
            if self.arm_names().all(|(known, _)| known != base) {
                let known = self.arm_names().map(|(known, _)| known.to_owned());
                let right = Choices::near(base, known.collect());
                let message = format!("{key}: there is no arm `{base}`{right}");
                let other = format!("arms.{base}");
                return Err(BrokenRule::new(key, message).beside(&[&other]));
            }
            passed.push(base);
        }
        Ok(())
    }
}

/// A key that no arm has.
fn stray(arm: &str, setting: &str, section: &str) -> BrokenRule {
    let key = format!("{arm}.{setting}");
    let message = match section {
        "env" | "run" => format!(
            "{key}: an arm cannot change [{section}]: all arms see the same world for as long, or they could not be compared"
        ),
        _ => {
            let keys = ["base", "about"].into_iter().chain(SECTIONS);
            let right = Choices::near(setting, keys.map(str::to_owned).collect());
            format!(
                "{key}: an arm has `base`, `about` and settings such as \"shaping.scale_factor\" = 2.0{right}"
            )
        }
    };
    BrokenRule::new(key, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agent::{AgentKind, Untried, UpdateRule};
    use crate::exploration::ExplorationKind;

    fn lay(name: &str, text: &str) -> Arm {
        let path = Path::new("x.toml");
        let scenario = Scenario::parse(path, text.to_owned(), &[])
            .unwrap()
            .scenario;
        let laid = scenario.lay_arm(name, path, text, &[]).unwrap();
        laid.unwrap_or_else(|| panic!("there is no arm {name}"))
    }

    fn refused(text: &str) -> String {
        Scenario::parse(Path::new("x.toml"), text.to_owned(), &[])
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn every_built_in_arm_is_accepted_and_no_two_are_the_same() {
        // Unlike in a scenario that asks for look-ahead advice, which the default does not.
        let text = "[exploration]\npotential_advice = 1\n";
        let arms: Vec<Arm> = BUILT_IN_ARMS
            .iter()
            .map(|arm| lay(arm.name, text))
            .collect();
        for (i, arm) in arms.iter().enumerate() {
            assert!(arms[..i].iter().all(|a| a.scenario != arm.scenario));
        }
    }

    #[test]
    fn gcn_is_the_default_scenario() {
        let plain = Scenario::parse(Path::new("x.toml"), String::new(), &[]);
        assert_eq!(lay("gcn", "").scenario, plain.unwrap().scenario);
    }

    #[test]
    fn an_arm_decides_its_own_keys_and_no_others() {
        let text = "[agent]\nkind = \"sarsa\"\ngamma = 0.9\n[shaping]\nscale_factor = 3\n";
        let gcn = lay("gcn", text).scenario;
        assert_eq!(gcn.agent.kind, AgentKind::ReplayActorCritic);
        assert_eq!(gcn.agent.gamma, 0.9);
        assert_eq!(gcn.shaping.scale_factor, 3.0);
        let q = lay("q-learning", text).scenario;
        assert_eq!(q.agent.kind, AgentKind::QLearning);
        assert_eq!(q.shaping.potential, PotentialKind::None);
        assert_eq!(q.exploration.kind, ExplorationKind::None);
        // Unset keys take the default of the arm's learner, not of the file's.
        assert_eq!(q.agent.q_learning().learning_rate, 1.0);
    }

    #[test]
    fn what_was_never_tried_is_advised_only_where_there_is_a_search() {
        for (text, untried) in [
            ("", Untried::Advised),
            ("[exploration]\nkind = \"none\"\n", Untried::Optimistic),
            (
                "[exploration]\nkind = \"none\"\n[agent]\nuntried = \"advised\"\n",
                Untried::Advised,
            ),
        ] {
            let scenario = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
            let agent = scenario.unwrap().scenario.agent;
            assert_eq!(agent.replay_actor_critic().untried, untried, "{text}");
        }
    }

    #[test]
    fn the_report_comes_with_its_own_step_sizes() {
        let agent = lay("report", "[agent]\nactor_learning_rate = 0.3\n")
            .scenario
            .agent;
        assert_eq!(agent.update, UpdateRule::Algorithm1);
        assert_eq!(agent.actor_critic().actor_learning_rate, 0.005);
    }

    #[test]
    fn an_own_arm_begins_as_its_base_in_any_notation() {
        for steep in [
            "[arms.steep]\nbase = \"heat\"\n\"shaping.scale_factor\" = 8.0\n",
            "[arms.steep]\nbase = \"heat\"\nshaping.scale_factor = 8.0\n",
            "[arms.steep]\nbase = \"heat\"\n[arms.steep.shaping]\nscale_factor = 8.0\n",
        ] {
            let text = format!("{steep}[arms.quick]\nbase = \"steep\"\nagent.gamma = 0.9\n");
            let (steep, quick) = (lay("steep", &text), lay("quick", &text));
            assert_eq!(steep.settings.last().unwrap(), "shaping.scale_factor=8.0");
            assert_eq!(steep.scenario.shaping.potential, PotentialKind::Heat);
            assert_eq!(steep.scenario.shaping.scale_factor, 8.0);
            assert_eq!(quick.scenario.shaping, steep.scenario.shaping);
            assert_eq!(quick.scenario.agent.gamma, 0.9);
            assert!(quick.scenario.arms.is_empty());
            assert_eq!(lay("heat", &text).scenario.agent.gamma, 1.0);
        }
        let plain = lay("mine", "[agent]\ngamma = 0.5\n[arms.mine]\n");
        assert_eq!(
            plain.scenario.agent.gamma, 0.5,
            "without a base: as it stands"
        );
    }

    #[test]
    fn slips_in_an_arm_are_placed_and_corrected() {
        for (text, expected) in [
            (
                "[arms.a]\nshaping.scale_facto = 2\n",
                "x.toml:2:23: unknown key `shaping.scale_facto`; did you mean `scale_factor`?",
            ),
            (
                "[arms.a]\n\"agent.knd\" = \"sarsa\"\n",
                "x.toml:2:15: unknown key `agent.knd`; did you mean `kind`?",
            ),
            (
                "[arms.a]\nagent.kind = \"sarssa\"\n",
                "x.toml:2:14: `agent.kind` cannot be \"sarssa\"; did you mean `sarsa`?",
            ),
            ("[arms.a]\nagent.gamma = 2\n", "x.toml:2:15: agent.gamma"),
            (
                "[arms.a]\nbase = \"gnc\"\n",
                "x.toml:2:8: arms.a.base: there is no arm `gnc`; did you mean `gcn`?",
            ),
            ("[arms.a]\nbsae = \"gcn\"\n", "; did you mean `base`?"),
            (
                "[arms.a]\nshapng.scale_factor = 1\n",
                "unknown key `shapng`; did you mean `shaping`?",
            ),
            ("[arms.a]\nenv.slip = 0.1\n", "an arm cannot change [env]"),
            (
                "[arms.a]\n\"run.episodes\" = 9\n",
                "an arm cannot change [run]",
            ),
            ("[arms.sparse]\n", "`sparse` is built in"),
            ("[arms.\"a/b\"]\n", "names a folder"),
            (
                "[arms.a]\nbase = \"b\"\n[arms.b]\nbase = \"a\"\n",
                "arms.b.base = \"a\" leads back to itself: a, b, a",
            ),
        ] {
            let message = refused(text);
            assert!(message.contains(expected), "{text}: {message}");
            assert!(message.starts_with("x.toml:"), "{message}");
        }
    }
}
