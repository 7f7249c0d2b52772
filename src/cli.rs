//! The command line as types: what can be asked, nothing of how it is done.

use crate::completions;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use clap_complete::engine::{ArgValueCandidates, ArgValueCompleter};
use eigentrail::scenario::{Axis, EnvKind, GridError};
use indexmap::IndexSet;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Turns the graph an agent is still discovering into a reward it can follow.
#[derive(Debug, Parser)]
#[command(name = "eigentrail", version, max_term_width = 100)]
#[command(after_help = "\
Exit codes: 0 ok, 1 failed while running, 2 usage, 3 bad input, 4 not converged under --strict,
129, 130, 143 interrupted by SIGHUP, Ctrl-C, SIGTERM. If stdout cannot be written the work is done
to its end all the same: then 0 if a pipe was closed (| head -1), else 1.
Results go to stdout, everything else to stderr.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Options of every command.
    #[command(flatten)]
    pub global: Global,
}

/// Options of every command.
#[derive(Args, Debug)]
pub struct Global {
    /// Say more on stderr: -v what happens, -vv every refresh and fit, -vvv everything
    #[arg(short, long, action = ArgAction::Count, global = true, help_heading = "Global options")]
    pub verbose: u8,
    /// Say less on stderr: -q errors only and no progress bar, -qq nothing but why it failed
    #[arg(short, long, action = ArgAction::Count, global = true, conflicts_with = "verbose", help_heading = "Global options")]
    pub quiet: u8,
    /// Threads to use [default: one per processor]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = thread_count, allow_negative_numbers = true, global = true, help_heading = "Global options")]
    pub threads: Option<usize>,
    /// When to colour; NO_COLOR is honoured too
    #[arg(
        long,
        value_name = "WHEN",
        default_value = "auto",
        global = true,
        help_heading = "Global options"
    )]
    pub color: ColorChoice,
    /// Write a Chrome trace (chrome://tracing, ui.perfetto.dev) to FILE
    #[arg(
        long,
        value_name = "FILE",
        global = true,
        help_heading = "Global options"
    )]
    pub trace: Option<PathBuf>,
    /// How log lines on stderr look
    #[arg(
        long,
        value_name = "FORMAT",
        default_value = "text",
        global = true,
        help_heading = "Global options"
    )]
    pub log_format: LogFormat,
}

/// When to colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColorChoice {
    /// On a terminal.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// How log lines look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Short lines for people.
    Text,
    /// One JSON object a line.
    Json,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scenario: explore, learn, write a run folder, print a summary
    Run(Run),
    /// Compare learners and potentials over the same seeds, with statistics
    Compare(Compare),
    /// Run every combination of a few values of a few keys over the same seeds; the same command goes on after an interruption
    Sweep(Sweep),
    /// Check a scenario without running it and print what it amounts to
    Check(Check),
    /// Draw a scenario's map, or the potential and the policy that a run has learnt on it
    Show(Show),
    /// Keep the lowest Laplacian eigenvectors of any growing graph up to date, no learning involved
    Track(Track),
    /// Compute a potential towards goals on any graph
    Potential(Potential),
    /// Show runs side by side, or a comparison, as one HTML page that needs nothing else
    Report(Report),
    /// Hand a run to other programs: its tables as CSV, Parquet or NumPy arrays, its graph as GraphML, DOT or Matrix Market
    Export(Export),
    /// Draw a scenario beside the actor-critic alone as one SVG, or the source paper's figures 4 to 9
    Figures(Figures),
    /// Tell what a checkpoint is of, and whether it is whole
    Inspect(Inspect),
    /// Print the JSON Schema of scenario files, for editors
    Schema,
    /// List the scenarios that come with the program, and the kinds of worlds and learners
    List(List),
    /// Print a new scenario with every key, its default and what it means
    New(New),
    /// Print a script that makes a shell complete commands, options, scenarios and arms
    ///
    /// It asks the program each time, so read it anew where a shell begins. In ~/.bashrc or ~/.zshrc:
    /// source <(eigentrail completions bash). In ~/.config/fish/config.fish: eigentrail completions fish | source
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page (roff)
    Man,
}

/// A scenario and what to change in it.
#[derive(Args, Debug)]
pub struct ScenarioArgs {
    /// A scenario file, or the name of a scenario that comes with the program (see `list`)
    #[arg(value_name = "SCENARIO.toml", add = ArgValueCompleter::new(completions::scenarios))]
    pub scenario: PathBuf,
    /// Change one key, for example --set agent.gamma=0.99; can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub sets: Vec<String>,
}

/// `eigentrail run`
#[derive(Args, Debug)]
pub struct Run {
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Master seed [default: run.seed of the scenario]
    #[arg(long, value_name = "N", value_parser = seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Several master seeds, side by side: a range a..b without its end, single seeds, or both, separated by commas
    #[arg(long, value_name = "SEEDS", value_parser = seeds, conflicts_with_all = ["seed", "serve", "serve_once"])]
    pub seeds: Option<Seeds>,
    /// Run folder [default: runs/NAME/TIME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on in an existing run folder: seeds that are finished there are not run again, others go on from their checkpoints
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Replace an existing run folder
    #[arg(long)]
    pub force: bool,
    /// Do not write report.html into the run folder
    #[arg(long)]
    pub no_report: bool,
    /// Do not write an event file for TensorBoard
    #[arg(long)]
    pub no_tensorboard: bool,
    /// Show the run in the browser, while it goes on and then until Ctrl-C [default address: 127.0.0.1:8765; port 0 takes any]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765", value_parser = address)]
    pub serve: Option<SocketAddr>,
    /// The same, but only while the run goes on
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765", value_parser = address, conflicts_with = "serve")]
    pub serve_once: Option<SocketAddr>,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// `eigentrail compare`
#[derive(Args, Debug)]
pub struct Compare {
    /// Scenario files, or names of scenarios that come with the program (see `list`)
    #[arg(value_name = "SCENARIO.toml", required = true, add = ArgValueCompleter::new(completions::scenarios))]
    pub scenarios: Vec<PathBuf>,
    /// Change one key for every arm, for example --set agent.gamma=0.99; can be repeated. What an arm sets itself wins
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub sets: Vec<String>,
    /// Master seeds: a range a..b without its end, single seeds, or both, separated by commas
    #[arg(long, value_name = "SEEDS", default_value = "0..20", value_parser = seeds)]
    pub seeds: Seeds,
    /// What to compare, separated by commas (see `list`)
    #[arg(
        long,
        value_name = "ARMS",
        value_delimiter = ',',
        default_value = "sparse,gcn,heat,planner",
        add = ArgValueCandidates::new(completions::arms)
    )]
    pub arms: Vec<String>,
    /// Compare also with a sparse arm whose step sizes are tuned for the world, on seeds of their own
    #[arg(long)]
    pub tuned: bool,
    /// Output folder [default: runs/NAME/TIME-compare]; of several scenarios each gets a folder in it
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on in an existing folder: what is finished there is not run again, the rest goes on from its checkpoints
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Replace an existing folder
    #[arg(long)]
    pub force: bool,
    /// Do not write report.html into the folder
    #[arg(long)]
    pub no_report: bool,
    /// Print the numbers as JSON
    #[arg(long, conflicts_with = "markdown")]
    pub json: bool,
    /// Print the tables as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// Print every column, however wide the terminal is [default: those that fit; 80 characters where there is none]
    #[arg(long, conflicts_with_all = ["json", "markdown"])]
    pub wide: bool,
}

/// `eigentrail sweep`
#[derive(Args, Debug)]
pub struct Sweep {
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// A key and its values, for example --grid agent.gamma=0.9,0.99; can be repeated. Commas within quotes, [ ] and { } are part of
    /// a value; what each may be is as with --set
    #[arg(long = "grid", value_name = "KEY=V1,V2,...", value_parser = axis, add = ArgValueCompleter::new(completions::axes))]
    pub grid: Vec<Axis>,
    /// Arms to lay over every point, separated by commas (see `list`) [default: the scenario as it stands]
    #[arg(
        long,
        value_name = "ARMS",
        value_delimiter = ',',
        add = ArgValueCandidates::new(completions::arms)
    )]
    pub arms: Vec<String>,
    /// Master seeds: a range a..b without its end, single seeds, or both, separated by commas
    #[arg(long, value_name = "SEEDS", default_value = "0..20", value_parser = seeds)]
    pub seeds: Seeds,
    /// Folder; what is finished there is not run again [default: runs/NAME/sweep-HASH, the hash of all points]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Remove what a sweep has left in the folder, and begin anew
    #[arg(long)]
    pub force: bool,
    /// Print the numbers as JSON
    #[arg(long, conflicts_with = "markdown")]
    pub json: bool,
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// Print every column, however wide the terminal is [default: those that fit; 80 characters where there is none]
    #[arg(long, conflicts_with_all = ["json", "markdown"])]
    pub wide: bool,
}

/// Master seeds in the order given, without duplicates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(pub Vec<u64>);

/// `eigentrail check`
#[derive(Args, Debug)]
pub struct Check {
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Print the scenario with every default written out
    #[arg(long)]
    pub resolved: bool,
    /// Print the facts as one line of JSON
    #[arg(long, conflicts_with = "resolved")]
    pub json: bool,
}

/// `eigentrail inspect`
#[derive(Args, Debug)]
pub struct Inspect {
    /// The checkpoint, `seed-0000/checkpoint` or `checkpoint-before` in the folder of a run
    pub checkpoint: PathBuf,
    /// Print the facts as one line of JSON
    #[arg(long)]
    pub json: bool,
}

/// `eigentrail show`
#[derive(Args, Debug)]
pub struct Show {
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Show the potential of this run folder (or of one seed folder in it)
    #[arg(long, value_name = "RUN")]
    pub potential: Option<PathBuf>,
    /// Show the greedy policy of this run folder (or of one seed folder in it)
    #[arg(long, value_name = "RUN")]
    pub policy: Option<PathBuf>,
    /// Fit the map into N characters [default: the terminal's width; the whole map elsewhere]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub width: Option<usize>,
    /// Draw with ASCII characters only
    #[arg(long)]
    pub ascii: bool,
    /// Print map, states and what was asked for of the run as one line of JSON
    #[arg(long, conflicts_with_all = ["width", "ascii"])]
    pub json: bool,
}

/// `eigentrail track`
#[derive(Args, Debug)]
pub struct Track {
    /// A symmetric Matrix Market file; its row order is the order of discovery
    #[arg(value_name = "GRAPH.mtx")]
    pub graph: PathBuf,
    /// How many of the lowest eigenpairs to keep [default: 16, or all of a graph with fewer nodes]
    #[arg(long, short, value_name = "K", value_parser = at_least_one, allow_negative_numbers = true)]
    pub k: Option<usize>,
    /// Which Laplacian of the graph with the adjacency W and the degrees D
    #[arg(long, value_name = "LAPLACIAN", default_value = "sym")]
    pub laplacian: LaplacianChoice,
    /// How much the graph grows from one update to the next, as a share of its nodes
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = positive, allow_negative_numbers = true)]
    pub growth: f64,
    /// Nodes of the first update: the graph grows from there
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = at_least_one, allow_negative_numbers = true)]
    pub from: usize,
    /// Largest residual accepted, relative to the largest eigenvalue kept
    #[arg(long, value_name = "TOL", default_value_t = 1e-2, value_parser = positive, allow_negative_numbers = true)]
    pub tol: f64,
    /// How each update finds the pairs
    #[arg(long, value_name = "METHOD", default_value = "warm")]
    pub method: MethodChoice,
    /// Seed of the random start vectors
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Prove at each update, by counting eigenvalues, that no pair was missed
    #[arg(long)]
    pub certify: bool,
    /// Write the eigenvectors of the whole graph, n × k, as a NumPy file
    #[arg(long, value_name = "OUT.npy")]
    pub vectors: Option<PathBuf>,
    /// Print the updates as JSON
    #[arg(long)]
    pub json: bool,
    /// Exit with 4 if an update did not converge, or under --certify could not be proved complete
    #[arg(long)]
    pub strict: bool,
}

/// Which Laplacian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LaplacianChoice {
    /// Symmetric, normalised by degree: I − D^-1/2 W D^-1/2, eigenvalues from 0 to 2
    Sym,
    /// D − W, eigenvalues from 0 to twice the largest degree
    Unnormalised,
}

/// How each update finds the pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodChoice {
    /// From the previous vectors, extended to the new nodes
    Warm,
    /// From random vectors every time
    Cold,
    /// Dense, all n pairs
    Full,
}

/// `eigentrail potential`
#[derive(Args, Debug)]
pub struct Potential {
    /// A symmetric Matrix Market file
    #[arg(value_name = "GRAPH.mtx")]
    pub graph: PathBuf,
    /// The goals, as node numbers: rows of the file in order, from 0
    #[arg(long, value_name = "NODE", num_args = 1.., value_delimiter = ',', required = true, value_parser = node, allow_negative_numbers = true)]
    pub goal: Vec<usize>,
    /// Which potential
    #[arg(long, value_name = "KIND", default_value = "gcn")]
    pub kind: PotentialChoice,
    /// Seed of the network's weights
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Write node and potential of every node as CSV
    #[arg(long, value_name = "PHI.csv")]
    pub out: Option<PathBuf>,
    /// Print the facts as JSON
    #[arg(long)]
    pub json: bool,
}

/// Which potential.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PotentialChoice {
    /// The soft value of the graph, at temperatures that a graph network sets
    Gcn,
    /// The probability of the rewarding class, as the paper prints it
    Report,
    /// The same at one temperature
    Heat,
    /// The value of the linearly solvable process, from the default representation
    Dr,
    /// Discounted visits of the goals, from the successor representation
    Sr,
    /// By the number of edges to the nearest goal
    Hops,
}

/// `eigentrail report`
#[derive(Args, Debug)]
pub struct Report {
    /// Run folders, or folders of run folders: each run is an arm of the page, named by what it differs in; runs of several worlds get
    /// a part for each. Or the folder of one comparison
    #[arg(value_name = "RUN", required = true)]
    pub runs: Vec<PathBuf>,
    /// Write the page to FILE, in the place of no file but an earlier page
    #[arg(short, long, value_name = "FILE.html", default_value = "report.html")]
    pub out: PathBuf,
}

/// `eigentrail export`
#[derive(Args, Debug)]
pub struct Export {
    /// A run folder, or one seed folder in it
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// As what
    #[arg(long, value_name = "FORMAT")]
    pub to: ExportFormat,
    /// Write to PATH, a folder for csv and parquet, a file for the others, or - for a graph to stdout
    /// [default: export, export.npz, graph.graphml, graph.dot or graph.mtx]
    #[arg(short, long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Replace what is there
    #[arg(long)]
    pub force: bool,
}

/// As what a run is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// A folder of episodes, refreshes, states and transitions as CSV
    Csv,
    /// The same as Parquet, for pandas, Polars and DuckDB (needs the feature `parquet`)
    Parquet,
    /// One file of NumPy arrays: every column, and the eigenvectors
    Npz,
    /// The graph, for Gephi, yEd, networkx and igraph
    Graphml,
    /// The graph, for Graphviz
    Dot,
    /// The graph without directions, as Matrix Market in order of discovery, for `track` and `potential`
    Mtx,
}

/// `eigentrail figures`
#[derive(Args, Debug)]
pub struct Figures {
    /// A scenario file, or the name of a scenario that comes with the program (see `list`): φ on its map at four
    /// moments, and the regret beside that of the actor-critic alone
    #[arg(value_name = "SCENARIO.toml", required_unless_present = "all", add = ArgValueCompleter::new(completions::scenarios))]
    pub scenario: Option<PathBuf>,
    /// Draw counterparts of the paper's figures 4 to 9 from the scenarios in scenarios/report, with a page around them
    #[arg(long, conflicts_with = "scenario")]
    pub all: bool,
    /// Change one key, for example --set agent.gamma=0.99; can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub sets: Vec<String>,
    /// Seeds of each arm, from 0; at most 10000
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub seeds: u64,
    /// Write to this file, or with --all into this folder, in the place of none but earlier figures [default: figure.svg, or the folder figures]
    #[arg(short, long, value_name = "PATH")]
    pub out: Option<PathBuf>,
}

/// `eigentrail list`
#[derive(Args, Debug)]
pub struct List {
    /// Print the lists as one line of JSON
    #[arg(long)]
    pub json: bool,
}

/// `eigentrail new`
#[derive(Args, Debug)]
pub struct New {
    /// The name of the scenario; the name of a kind of world asks for that kind, as --kind does
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Write out the keys that make a world of this kind, and leave out those of others
    #[arg(long, value_name = "KIND", value_parser = env_kind())]
    pub kind: Option<EnvKind>,
}

/// Kinds of worlds by name.
fn env_kind() -> impl TypedValueParser<Value = EnvKind> {
    let names = EnvKind::ALL.map(EnvKind::name);
    PossibleValuesParser::new(names).map(|name| {
        let kind = EnvKind::ALL.into_iter().find(|kind| kind.name() == name);
        kind.expect("only these names are possible")
    })
}

/// A whole number of at least 1.
fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err("expected a whole number from 1".to_owned()),
        Ok(n) => Ok(n),
    }
}

/// Threads beyond this only cost: no machine has so many processors.
const MOST_THREADS: usize = 1024;

/// A number of threads that a machine can start.
fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MOST_THREADS).contains(&n) => Ok(n),
        _ => Err(format!("expected a whole number from 1 to {MOST_THREADS}")),
    }
}

/// Where to listen.
fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| "expected an address with a port, such as 127.0.0.1:8765".to_owned())
}

/// Any whole number of 64 bits.
fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// The number of a node.
fn node(text: &str) -> Result<usize, String> {
    text.parse()
        .map_err(|_| "expected the number of a node, from 0".to_owned())
}

/// `0..20`, `1,5,9`, or both.
fn seeds(text: &str) -> Result<Seeds, String> {
    /// So many that a slip of the finger is more likely than an experiment.
    const MOST: usize = 100_000;
    let whole = |number: &str| {
        let number = number.trim().parse::<u64>();
        number.map_err(|_| "expected seeds as 0..20 or 1,2,3".to_owned())
    };
    let mut seeds = IndexSet::new();
    for part in text.split(',') {
        let (from, to) = match part.split_once("..") {
            Some((from, to)) => (whole(from)?, whole(to)?),
            None => (whole(part)?, whole(part)?.saturating_add(1)),
        };
        if from >= to {
            return Err(format!("the range {part} is empty"));
        }
        if to - from > MOST as u64 {
            return Err(format!("the range {part} has more than {MOST} seeds"));
        }
        seeds.extend(from..to);
        if seeds.len() > MOST {
            return Err(format!("these are more than {MOST} seeds"));
        }
    }
    Ok(Seeds(seeds.into_iter().collect()))
}

/// A finite number above 0.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// `section.key=value,value`
fn axis(text: &str) -> Result<Axis, String> {
    text.parse().map_err(|error: GridError| error.to_string())
}

/// `section.key=value`, to be understood by the scenario.
fn key_value(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((key, _)) if !key.trim().is_empty() => Ok(text.to_owned()),
        _ => Err("expected section.key=value".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn seeds_are_ranges_and_single_numbers() {
        assert_eq!(seeds("3..6, 9,4").unwrap().0, [3, 4, 5, 9]);
        assert!(seeds("5..5").unwrap_err().contains("empty"));
        assert!(seeds("0..1000000000").unwrap_err().contains("more than"));
        assert!(seeds("0..100000,200000..300000").is_err());
        assert_eq!(seeds("0..100000,0..100000").unwrap().0.len(), 100_000);
        assert_eq!(
            seeds("18446744073709551614,0").unwrap().0,
            [u64::MAX - 1, 0]
        );
        for wrong in ["", "a", "1..", "-1", "1.5", "1,,2"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
    }
}
