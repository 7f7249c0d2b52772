//! Engines that are written down in the middle of an episode and go on in another process.

use crate::results::hex;
use eigentrail::agent::AnyAgent;
use eigentrail::engine::Engine;
use eigentrail::env::Model;
use eigentrail::runner::{build_engine, move_goals, with_discovery_hook};
use eigentrail::scenario::{Loaded, Scenario, World};
use libtest_mimic::{Failed, Trial};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const SEED: u64 = 0;
/// Set for a process that is to go on with the engine in this file.
const ENGINE: &str = "EIGENTRAIL_GOLDEN_ENGINE";
/// The file of its scenario.
const SCENARIO: &str = "EIGENTRAIL_GOLDEN_SCENARIO";

/// What another process is to go on with.
pub struct Order {
    engine: PathBuf,
    scenario: PathBuf,
}

impl Order {
    /// The order that this process was started with, if it was.
    pub fn of_this_process() -> Option<Self> {
        let path = |name| std::env::var_os(name).map(PathBuf::from);
        Some(Self {
            engine: path(ENGINE)?,
            scenario: path(SCENARIO)?,
        })
    }
}

/// Goes on, and prints the digest of what came of it.
pub fn obey(order: &Order) -> ExitCode {
    match go_on(order) {
        Ok(digest) => {
            print!("{digest}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The test that a scenario goes on as if nothing had happened.
pub fn trial(scenario: PathBuf) -> Trial {
    let stem = scenario.file_stem().unwrap_or_default().to_string_lossy();
    Trial::test(format!("continued/{stem}"), move || {
        let loaded = load(&scenario)?;
        match loaded.worlds.first_for(SEED) {
            World::Grid(world) => compare(&scenario, &loaded, world, grid),
            World::Listed(world, _) => compare(&scenario, &loaded, world, listed),
        }
    })
}

fn load(scenario: &Path) -> Result<Loaded, String> {
    Scenario::load(scenario, &[]).map_err(|e| e.to_string())
}

fn grid(world: World) -> Option<eigentrail::env::GridWorld> {
    match world {
        World::Grid(world) => Some(world),
        World::Listed(..) => None,
    }
}

fn listed(world: World) -> Option<eigentrail::env::TabularEnvironment> {
    match world {
        World::Listed(world, _) => Some(world),
        World::Grid(_) => None,
    }
}

/// A run of a scenario, and the episodes that it has played.
struct Run<'a, E: Model> {
    scenario: &'a Scenario,
    engine: Engine<E, AnyAgent>,
    episodes: usize,
    /// The world to come, and after how many episodes.
    moved: Option<(usize, E)>,
    digest: Sha256,
}

/// What a world must be to be written down.
trait Plain:
    Model<State: Send + Serialize + DeserializeOwned>
    + Clone
    + Send
    + Serialize
    + DeserializeOwned
    + 'static
{
}

impl<E> Plain for E where
    E: Model<State: Send + Serialize + DeserializeOwned>
        + Clone
        + Send
        + Serialize
        + DeserializeOwned
        + 'static
{
}

impl<E: Plain> Run<'_, E> {
    fn is_over(&self) -> bool {
        self.episodes == self.scenario.run.episodes
    }

    fn step(&mut self) -> Result<(), String> {
        if !self.engine.pipeline().walker().is_in_episode()
            && let Some((_, world)) = self.moved.take_if(|(after, _)| *after == self.episodes)
        {
            move_goals(self.scenario, &mut self.engine, world);
        }
        let digest = &mut self.digest;
        let ended = self.engine.step(|refresh, pipeline| {
            digest.update(refresh.step.to_le_bytes());
            for phi in pipeline.potential().values() {
                digest.update(phi.to_bits().to_le_bytes());
            }
        });
        if let Some(record) = ended.map_err(|e| e.to_string())? {
            self.episodes += 1;
            self.digest.update(written(&record)?);
        }
        Ok(())
    }

    /// Plays all that is left: the digest of every refresh and episode since `digest` was begun, and of the engine at the end.
    fn finish(mut self) -> Result<String, String> {
        while !self.is_over() {
            self.step()?;
        }
        self.digest.update(written(&self.engine)?);
        Ok(hex(&self.digest.finalize()))
    }
}

/// Plays the scenario once to count its steps, then again, writing the engine down at a third and at two thirds of
/// them; another process goes on from either file.
fn compare<E: Plain>(
    path: &Path,
    loaded: &Loaded,
    world: E,
    own: fn(World) -> Option<E>,
) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let begin = || -> Result<Run<'_, E>, String> {
        let moved = loaded.worlds.moved_for(SEED);
        Ok(Run {
            scenario: &loaded.scenario,
            engine: build_engine(&loaded.scenario, world.clone(), None, SEED)
                .map_err(|e| e.to_string())?,
            episodes: 0,
            moved: moved.and_then(|moved| Some((moved.after, own(moved.world)?))),
            digest: Sha256::new(),
        })
    };
    let mut whole = begin()?;
    while !whole.is_over() {
        whole.step()?;
    }
    for third in [1, 2] {
        let mut run = begin()?;
        let due = whole.engine.steps() * third / 3;
        let is_due = |run: &Run<'_, E>| {
            run.engine.steps() >= due && run.engine.pipeline().walker().is_in_episode()
        };
        while !is_due(&run) && !run.is_over() {
            run.step()?;
        }
        if run.is_over() {
            return Err("no episode is long enough to be interrupted".into());
        }
        let file = folder.path().join("engine");
        std::fs::write(&file, written(&(run.episodes, &run.engine))?)?;
        run.digest = Sha256::new();
        let (expected, found) = (run.finish()?, elsewhere(path, &file)?);
        if found != expected {
            return Err(format!("from step {due} on another process played otherwise").into());
        }
    }
    Ok(())
}

fn written(value: &impl Serialize) -> Result<Vec<u8>, String> {
    rmp_serde::to_vec(value).map_err(|e| e.to_string())
}

/// The digest of what another process plays.
fn elsewhere(scenario: &Path, engine: &Path) -> Result<String, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = Command::new(program);
    command.env(ENGINE, engine).env(SCENARIO, scenario);
    let output = command.output().map_err(|e| e.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    match output.status.success() {
        true => Ok(text(&output.stdout)),
        false => Err(text(&output.stderr)),
    }
}

fn go_on(order: &Order) -> Result<String, String> {
    let loaded = load(&order.scenario)?;
    match loaded.worlds.first() {
        World::Grid(_) => go_on_in(order, &loaded, grid),
        World::Listed(..) => go_on_in(order, &loaded, listed),
    }
}

fn go_on_in<E: Plain>(
    order: &Order,
    loaded: &Loaded,
    own: fn(World) -> Option<E>,
) -> Result<String, String> {
    let bytes = std::fs::read(&order.engine).map_err(|e| e.to_string())?;
    let (episodes, engine): (usize, Engine<E, AnyAgent>) =
        rmp_serde::from_slice(&bytes).map_err(|e| e.to_string())?;
    if written(&(episodes, &engine))? != bytes {
        return Err("written again it is not the same".to_owned());
    }
    let moved = loaded.worlds.moved_for(SEED);
    let moved = moved.filter(|moved| moved.after > episodes);
    let run = Run {
        scenario: &loaded.scenario,
        engine: with_discovery_hook(&loaded.scenario, engine, None),
        episodes,
        moved: moved.and_then(|moved| Some((moved.after, own(moved.world)?))),
        digest: Sha256::new(),
    };
    run.finish()
}
