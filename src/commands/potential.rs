//! `eigentrail potential`

use super::{BadInput, Ending, require_writable};
use crate::cli::{self, PotentialChoice};
use crate::output::{print, print_json};
use anyhow::{Context, Result};
use eigentrail::archive::files::write_atomically;
use eigentrail::error::{Error, ErrorKind};
use eigentrail::graph::{StateId, matrix_market};
use eigentrail::runner::potential_of_graph;
use eigentrail::shaping::PotentialKind;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// `potential --json`
#[derive(Serialize)]
struct PotentialLine {
    n: usize,
    kind: &'static str,
    spurious_maxima: usize,
    seconds: f64,
}

pub fn potential(args: &cli::Potential) -> Result<Ending> {
    require_writable(args.out.as_deref())?;
    let graph = matrix_market::load(&args.graph).map_err(Error::from)?;
    let adjacency = graph.to_csr();
    let n = adjacency.num_nodes();
    if let Some(node) = args.goal.iter().find(|&&node| node >= n) {
        let path = args.graph.display();
        let last = n.saturating_sub(1);
        return Err(BadInput(format!(
            "{path}: --goal {node}: the nodes are numbered from 0 to {last}"
        ))
        .into());
    }
    let goals: Vec<StateId> = args.goal.iter().map(|&node| StateId(node as u32)).collect();
    let kind = kind(args.kind);
    let found = potential_of_graph(&adjacency, &goals, kind, args.seed).map_err(|error| {
        let error = Error::from(error);
        match error.kind() {
            ErrorKind::BadInput => BadInput(format!("{}: {error}", args.graph.display())).into(),
            _ => anyhow::Error::from(error),
        }
    })?;
    if let Some(path) = &args.out {
        write_csv(path, &found.values)?;
    }
    let line = PotentialLine {
        n,
        kind: kind.name(),
        spurious_maxima: found.spurious_maxima.len(),
        seconds: found.seconds,
    };
    if args.json {
        print_json(&line);
    } else {
        print(&text(&line, &found.values));
    }
    Ok(Ending::Done)
}

fn kind(choice: PotentialChoice) -> PotentialKind {
    match choice {
        PotentialChoice::Gcn => PotentialKind::Gcn,
        PotentialChoice::Report => PotentialKind::Report,
        PotentialChoice::Heat => PotentialKind::Heat,
        PotentialChoice::Dr => PotentialKind::Dr,
        PotentialChoice::Sr => PotentialKind::Sr,
        PotentialChoice::Hops => PotentialKind::Hops,
    }
}

fn write_csv(path: &Path, values: &[f64]) -> Result<()> {
    let written = write_atomically(path, |file| {
        writeln!(file, "node,potential")?;
        for (node, value) in values.iter().enumerate() {
            writeln!(file, "{node},{value}")?;
        }
        Ok(())
    });
    written.with_context(|| format!("{}: cannot write", path.display()))
}

fn text(line: &PotentialLine, values: &[f64]) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!(
        "{} nodes, potential {}, from {low:.3} to {high:.3}\nfalse maxima {}\n{:.3} s",
        line.n, line.kind, line.spurious_maxima, line.seconds
    )
}
