//! Every mistake of a scenario at once.
//!
//! What reads and checks a scenario stops at the first mistake. So that key is passed over, as if it had not been written, and
//! all is read and checked again, until nothing more is found. A key that is passed over has its default, of which others may
//! then seem to be wrong: a rule that is about several keys is not held against one while another of them is.

use super::document::{Document, Found, Setting};
use super::error::{BrokenRule, Mistake, ScenarioError};
use super::{CHECKS, Scenario};
use std::collections::HashSet;
use std::path::Path;

/// So many are told at most: to find the next one all is read again.
pub(super) const MOST_MISTAKES: usize = 100;

/// Completes what was read before it is checked.
pub(super) type Amend<'a> = &'a dyn Fn(&mut Scenario);

/// A scenario under examination.
pub(super) struct Examination<'a> {
    document: Document,
    amend: Amend<'a>,
    /// What could be read of it; none if not even that, the defaults aside, makes one.
    scenario: Option<Scenario>,
    /// Keys that are wrong, and those that misspelt ones were meant to be.
    unsound: Vec<String>,
    mistakes: Vec<Mistake>,
}

impl<'a> Examination<'a> {
    /// That of a file, with assignments of the command line laid over it.
    ///
    /// # Errors
    /// If the file is not TOML.
    pub fn of_file(path: &Path, text: String, laid: &[Setting]) -> Result<Self, ScenarioError> {
        let document = Document::new(path, text)?;
        Ok(Self::of(document, laid, &|_| {}))
    }

    /// That of a document with settings laid over it. Its types are read; no rule is checked yet.
    pub fn of(document: Document, settings: &[Setting], amend: Amend<'a>) -> Self {
        Self::knowing(Vec::new(), document, settings, amend)
    }

    /// The same, of which some keys are known to be wrong already.
    fn knowing(
        unsound: Vec<String>,
        mut document: Document,
        settings: &[Setting],
        amend: Amend<'a>,
    ) -> Self {
        let laid = settings.iter().map(|setting| document.lay(setting));
        let mistakes = laid.filter_map(Result::err).collect();
        let mut examination = Self {
            document,
            amend,
            scenario: None,
            unsound,
            mistakes,
        };
        examination.read();
        examination
    }

    /// The document, with what is passed over of it.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// What is left of the scenario without its mistakes.
    pub fn scenario(&self) -> Option<&Scenario> {
        self.scenario.as_ref()
    }

    /// Checks every section by itself.
    pub fn sections(&mut self) {
        for check in CHECKS {
            self.until_sound(check);
        }
    }

    /// What `check` makes of the scenario as soon as it finds nothing wrong any more; none if it never does.
    pub fn until_sound<T>(
        &mut self,
        check: impl Fn(&Scenario) -> Result<T, BrokenRule>,
    ) -> Option<T> {
        loop {
            let broken = match check(self.scenario.as_ref()?) {
                Ok(made) => return Some(made),
                Err(broken) => broken,
            };
            if !self.note(broken) {
                return None;
            }
        }
    }

    /// Notes a broken rule and reads the rest again. False if what is to blame is not written, so that it cannot be passed over.
    pub fn note(&mut self, mut broken: BrokenRule) -> bool {
        let is_sure = !broken.others.iter().any(|other| self.doubts(other));
        let more = std::mem::take(&mut broken.more);
        let found = self.document.blame(broken);
        let (place, key) = (found.mistake.place(), found.key.clone());
        let known = self.mistakes.len();
        let is_passed = self.pass_over(found, is_sure);
        if self.mistakes.len() > known {
            let more = more.into_iter().map(|message| Mistake::Rule {
                place: place.clone(),
                key: key.clone(),
                message,
            });
            self.mistakes.extend(more);
        }
        if is_passed {
            self.read();
        }
        is_passed
    }

    /// Examines the same document with settings laid over it, whose mistakes are those of this one. What comes out; none if
    /// there are any.
    pub fn also(&mut self, settings: &[Setting], amend: Amend<'_>) -> Option<Scenario> {
        let is_set = |key: &String| settings.iter().any(|setting| setting.key() == key);
        let known = self.unsound.iter().filter(|key| !is_set(key)).cloned();
        let document = self.document.clone();
        let mut other = Examination::knowing(known.collect(), document, settings, amend);
        other.sections();
        let is_sound = other.mistakes.is_empty();
        self.mistakes.append(&mut other.mistakes);
        other.scenario.filter(|_| is_sound)
    }

    /// The scenario, if nothing is wrong with it.
    ///
    /// # Errors
    /// All that was found.
    pub fn finish(mut self) -> Result<Scenario, ScenarioError> {
        if let (Some(scenario), true) = (&self.scenario, self.mistakes.is_empty()) {
            return Ok(scenario.clone());
        }
        let mut told = HashSet::new();
        self.mistakes
            .retain(|mistake| told.insert(mistake.to_string()));
        self.mistakes
            .sort_by_cached_key(|mistake| self.document.order(&mistake.place()));
        let is_named = !self.unsound.iter().any(|key| key == "name");
        Err(ScenarioError {
            file: self.document.path().to_owned(),
            scenario: self
                .scenario
                .filter(|_| is_named)
                .map(|scenario| scenario.name),
            mistakes: self.mistakes,
        })
    }

    /// Reads the document, without the keys that cannot be read.
    fn read(&mut self) {
        self.scenario = None;
        loop {
            let found = match self.document.deserialize::<Scenario>() {
                Ok(scenario) => {
                    let scenario = self.scenario.insert(scenario);
                    scenario.complete(self.document.path());
                    return (self.amend)(scenario);
                }
                Err(found) => *found,
            };
            if !self.pass_over(found, true) {
                return;
            }
        }
    }

    /// Passes over what is to blame for a mistake, and notes it unless it only follows from others. False if there is nothing
    /// more to pass over, or nobody would read on.
    fn pass_over(&mut self, found: Found, is_sure: bool) -> bool {
        let is_new = is_sure && !self.doubts(&found.key);
        let word = match (&found.mistake, &found.meant) {
            (Mistake::UnknownChoice { .. }, Some(word)) => Some(word.clone()),
            _ => None,
        };
        if let (Mistake::UnknownKey { .. }, Some(meant)) = (&found.mistake, &found.meant) {
            let section = found.key.rfind('.').map_or("", |end| &found.key[..=end]);
            let meant = format!("{section}{meant}");
            if !self.document.is_written(&meant) {
                self.unsound.push(meant);
            }
        }
        self.unsound.push(found.key);
        if is_new {
            self.mistakes.push(found.mistake);
        }
        if self.mistakes.len() >= MOST_MISTAKES {
            return false;
        }
        match found.range {
            Some(range) if word.is_some() && self.document.mend(range.clone(), word) => true,
            Some(range) => self.document.mend(range, None),
            None => false,
        }
    }

    /// Whether something is wrong with this key, in it, or with what it is in.
    fn doubts(&self, key: &str) -> bool {
        let is_in = |inner: &str, outer: &str| {
            let rest = inner.strip_prefix(outer);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let mut unsound = self.unsound.iter();
        unsound.any(|wrong| is_in(wrong, key) || is_in(key, wrong))
    }
}
