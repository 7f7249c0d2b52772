//! Experiments as files: a scenario is a TOML file of flat tables, one for each part of the program.
//!
//! Every key has a default, an unknown key is an error that names the nearest right one, and choices are words.
//! [`Scenario::load`] reads a file, lays the assignments of the command line over it and checks the whole; what
//! comes out is complete and can be run. Its sections stand in the order in which data flows:
//!
//! | section | what | owner |
//! |---|---|---|
//! | `[env]` | the world | [`EnvParams`] |
//! | `[spectral]` | the eigenvectors | [`SpectralParams`] |
//! | `[deepwalk]` | random walks, an alternative to the eigenvectors | [`DeepWalkParams`] |
//! | `[gcn]` | the graph network | [`GcnParams`] |
//! | `[shaping]` | the potential | [`ShapingParams`] |
//! | `[exploration]` | before the first goal | [`ExplorationParams`] |
//! | `[agent]` | the learner | [`AgentParams`] |
//! | `[schedule]` | when to refresh and to fit | [`ScheduleParams`] |
//! | `[run]` | how long | [`RunParams`] |
//! | `[arms.NAME]` | what to compare, beside the built-in arms | [`ArmParams`] |

mod arms;
mod built_in_arms;
mod document;
mod env;
mod error;
mod examination;
mod goals;
mod grid;
mod idle_keys;
mod keys;
mod layout;
mod magnitude;
mod place;
mod potential_file;
mod shipped;
mod start;
mod template;
mod world;
mod worlds;

pub use arms::{Arm, ArmParams};
pub use built_in_arms::{BASELINE, BUILT_IN_ARMS, BuiltInArm, DEFAULT_ARM};
pub use env::{Actions, EnvKind, EnvParams};
pub use error::{BrokenRule, Choices, Location, Mistake, ScenarioError, nearest};
pub use goals::{Draw, GoalSpec, Goals, HazardSpec};
pub use grid::{Axis, GridError, GridPoint, grid};
pub use place::{MaxSteps, MoveAfter, Place};
pub use potential_file::PotentialFile;
pub use shipped::{Shipped, report_scenarios, shipped};
pub use start::{Start, WeightedPlace};
pub use template::template;
pub use world::{MovedWorld, Names, World};
pub use worlds::Worlds;

use self::document::Setting;
use self::examination::Examination;
use crate::agent::{AgentParams, Untried};
use crate::engine::ScheduleParams;
use crate::exploration::{ExplorationKind, ExplorationParams};
use crate::features::DeepWalkParams;
use crate::gcn::GcnParams;
use crate::parameter::{ParameterError, Section};
use crate::shaping::ShapingParams;
use crate::spectral::SpectralParams;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Length of a run, and its seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RunParams {
    /// Episodes to run, 1 to 1 000 000 000.
    pub episodes: usize,
    /// Master seed, unless the command line gives another one.
    pub seed: u64,
    /// A checkpoint is taken after so many environment steps, from which an interrupted run goes on; 0: not by steps.
    pub checkpoint_every_steps: u64,
    /// A checkpoint is taken after so many minutes, at most 1e6; 0: not by the clock. Whatever these two say, one is taken when the
    /// run is told to stop.
    pub checkpoint_every_minutes: f64,
}

impl Default for RunParams {
    fn default() -> Self {
        Self {
            episodes: 500,
            seed: 0,
            checkpoint_every_steps: 0,
            checkpoint_every_minutes: 5.0,
        }
    }
}

/// The length of each episode is kept: more than these are gigabytes.
const MOST_EPISODES: usize = 1_000_000_000;

impl RunParams {
    /// Checks the numbers.
    ///
    /// # Errors
    /// If it is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let section = Section("run");
        section.count("episodes", self.episodes, 1..=MOST_EPISODES)?;
        let minutes = self.checkpoint_every_minutes;
        let holds = (0.0..=1e6).contains(&minutes);
        section.number(
            "checkpoint_every_minutes",
            minutes,
            holds,
            "must be from 0 to 1e6",
        )
    }
}

/// A complete experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// Name of the experiment and of its folder of runs: letters, digits, `-`, `_`, `.`; by default that of the file.
    pub name: String,
    /// The world.
    pub env: EnvParams,
    /// The eigenvectors of the graph of visited states.
    pub spectral: SpectralParams,
    /// Random walks on the graph of visited states, where `deepwalk` features are asked for.
    pub deepwalk: DeepWalkParams,
    /// The graph network.
    pub gcn: GcnParams,
    /// The potential and the shaped reward.
    pub shaping: ShapingParams,
    /// What guides the agent before its first goal.
    pub exploration: ExplorationParams,
    /// The learner.
    pub agent: AgentParams,
    /// When to refresh the spectrum and when to fit again.
    pub schedule: ScheduleParams,
    /// How long, and from which seed.
    pub run: RunParams,
    /// Arms of your own for `compare`, by name, beside those that are built in (see `list`).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub arms: BTreeMap<String, ArmParams>,
}

/// A scenario with the file it came from and the worlds that it describes.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario, complete and checked.
    pub scenario: Scenario,
    /// The text of the file, without the assignments of the command line.
    pub text: String,
    /// Its worlds, the same for all its arms.
    pub worlds: Worlds,
    /// What its author may not have meant, each with its place: short lines of a map, and keys that have no effect (of which nothing
    /// is said where there are arms, which may read what the scenario itself does not).
    pub cautions: Vec<String>,
}

impl Scenario {
    /// Reads a scenario file, or the shipped scenario of that name if there is no such file, and lays assignments
    /// `section.key=value` over it.
    ///
    /// # Errors
    /// [`ScenarioError`]: every mistake with file, line and column, or the assignment to blame.
    pub fn load(path: &Path, sets: &[String]) -> Result<Loaded, ScenarioError> {
        Self::parse(path, Self::read(path)?, sets)
    }

    /// The text of a scenario file, or of the shipped scenario of that name if there is no such file.
    ///
    /// # Errors
    /// If there is neither.
    pub fn read(path: &Path) -> Result<String, ScenarioError> {
        std::fs::read_to_string(path).or_else(|source| match Shipped::named(path) {
            Some(found) => Ok(found.text.to_owned()),
            None => Err(ScenarioError {
                file: path.to_owned(),
                scenario: None,
                mistakes: vec![unreadable(path, source)],
            }),
        })
    }

    /// The same for a text that came from elsewhere; `path` serves messages, the name, and relative files.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(path: &Path, text: String, sets: &[String]) -> Result<Loaded, ScenarioError> {
        Self::parse_laid(path, text, &Setting::typed(sets))
    }

    /// The same with settings that know their places.
    fn parse_laid(path: &Path, text: String, laid: &[Setting]) -> Result<Loaded, ScenarioError> {
        let mut examined = Examination::of_file(path, text, laid)?;
        examined.sections();
        let mut worlds = examined.until_sound(Worlds::of);
        arms::examine(&mut examined, worlds.as_mut());
        let document = examined.document().clone();
        let scenario = examined.finish()?;
        let mut cautions = match scenario.arms.is_empty() {
            true => idle_keys::cautions(&scenario, &document),
            false => Vec::new(),
        };
        let ragged = scenario.env.map.as_deref().and_then(layout::ragged);
        cautions
            .extend(ragged.map(|caution| format!("{}: {caution}", document.place_of("env.map"))));
        Ok(Loaded {
            cautions,
            scenario,
            text: document.into_text(),
            worlds: worlds.expect("a scenario without mistakes has worlds"),
        })
    }

    /// The scenario as TOML with every default written out.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a scenario is made of what TOML can hold")
    }

    /// The value of every key that has one, by its name with dots: `agent.gamma`.
    pub fn settings(&self) -> BTreeMap<String, toml::Value> {
        let whole = toml::Value::try_from(self).expect("a scenario is made of what TOML can hold");
        let mut settings = BTreeMap::new();
        for (section, value) in whole.as_table().into_iter().flatten() {
            arms::flatten_into(&mut settings, section.clone(), value.clone());
        }
        settings
    }

    /// The JSON Schema of scenario files.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(Scenario).to_value()
    }

    /// Writes out the defaults that depend on other keys, and where relative paths begin.
    fn complete(&mut self, path: &Path) {
        if self.name.is_empty() {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            self.name = stem.replace(|c| !is_name_character(c), "-");
        }
        let folder = path.parent().map(PathBuf::from).unwrap_or_default();
        let files = [&mut self.env.file, &mut self.shaping.file];
        for file in files.into_iter().flatten() {
            *file = folder.join(&*file);
        }
        self.env.fill_defaults();
        if self.exploration.kind != ExplorationKind::Frontier {
            // Nobody would advise what was never tried.
            self.agent.untried.get_or_insert(Untried::Optimistic);
        }
        self.arms.values_mut().for_each(ArmParams::flatten);
    }

    /// TOML and JSON hold Unicode only, so the records of a run could not name the file.
    fn require_unicode_paths(&self) -> Result<(), BrokenRule> {
        let files = [
            ("env.file", &self.env.file),
            ("shaping.file", &self.shaping.file),
        ];
        for (key, file) in files {
            if let Some(file) = file.as_ref().filter(|file| file.to_str().is_none()) {
                let message = format!(
                    "{key}: the path {} is not UTF-8: rename the folder or the file",
                    file.display()
                );
                return Err(BrokenRule::new(key, message));
            }
        }
        Ok(())
    }

    /// Checks the section `[shaping]`.
    fn check_shaping(&self) -> Result<(), BrokenRule> {
        let checked = self.shaping.validate();
        checked.map_err(|error| match error.key {
            "potential" | "file" => {
                BrokenRule::from(error).beside(&["shaping.potential", "shaping.file"])
            }
            _ => error.into(),
        })
    }

    /// Checks every section, and that they go together; builds the world to see that it is one.
    ///
    /// # Errors
    /// The first broken rule, with the key to blame.
    pub fn validate(&self) -> Result<(), BrokenRule> {
        self.validate_sections()?;
        Worlds::of(self).map(drop)
    }

    /// Checks every section by itself, without the world, whose file may be elsewhere by now.
    ///
    /// # Errors
    /// The first broken rule, with the key to blame.
    pub(crate) fn validate_sections(&self) -> Result<(), BrokenRule> {
        CHECKS.iter().try_for_each(|check| check(self))
    }
}

/// A check of a scenario, which finds the first rule that is broken.
type Check = fn(&Scenario) -> Result<(), BrokenRule>;

/// What is checked of the sections, each by itself.
const CHECKS: [Check; 12] = [
    |scenario| check_name(&scenario.name),
    |scenario| scenario.env.check_numbers(),
    |scenario| scenario.env.validate(),
    Scenario::require_unicode_paths,
    |scenario| {
        let checked = scenario.spectral.validate();
        Ok(checked.map_err(ParameterError::from)?)
    },
    |scenario| Ok(scenario.deepwalk.validate()?),
    |scenario| Ok(scenario.gcn.validate()?),
    |scenario| scenario.check_shaping(),
    |scenario| Ok(scenario.exploration.validate()?),
    |scenario| Ok(scenario.agent.validate()?),
    |scenario| Ok(scenario.schedule.validate()?),
    |scenario| Ok(scenario.run.validate()?),
];

/// Checks that `name` can name a scenario, and so a folder.
///
/// # Errors
/// If it is empty, begins with a dot, or has characters other than letters, digits, `-`, `_` and `.`.
pub fn check_name(name: &str) -> Result<(), BrokenRule> {
    if !name.is_empty() && !name.starts_with('.') && name.chars().all(is_name_character) {
        return Ok(());
    }
    let rule = "names a folder: use letters, digits, -, _ and ., and no . at the beginning";
    Err(BrokenRule::new("name", format!("name = {name:?} {rule}")))
}

fn is_name_character(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-_.".contains(c)
}

/// A missing file, with what may have been meant.
fn unreadable(path: &Path, source: std::io::Error) -> Mistake {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let near = nearest(&stem, shipped().iter().map(|s| s.name));
    let is_name = path.as_os_str() == path.file_stem().unwrap_or_default();
    let hint = if is_name && BUILT_IN_ARMS.iter().any(|arm| arm.name == stem) {
        format!("; `{stem}` is an arm: `--arms` takes them with commas between, gcn,{stem}")
    } else {
        match near {
            Some(near) if is_name => {
                format!(", nor does a scenario of that name come with the program; did you mean `{near}`?")
            }
            None if is_name => {
                ", nor does a scenario of that name come with the program: `eigentrail list` names them".to_owned()
            }
            Some(near) => {
                format!("; `{near}` alone names the scenario that comes with the program")
            }
            None => String::new(),
        }
    };
    Mistake::Read {
        path: path.to_owned(),
        source,
        hint,
    }
}
