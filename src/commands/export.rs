//! `eigentrail export`

use super::{BadInput, Ending, require_writable};
use crate::cli::{self, ExportFormat};
use crate::output::{print, print_with};
use anyhow::Result;
use eigentrail::error::Error;
use eigentrail::export::{self, Format, Source};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

pub fn export(args: &cli::Export) -> Result<Ending> {
    let format = format(args.to);
    let source = Source::open(&args.run).map_err(Error::from)?;
    if args.out.as_deref() == Some(Path::new("-")) {
        return to_stdout(&source, format);
    }
    let out = match &args.out {
        Some(out) => out.clone(),
        None => default_out(format),
    };
    match format {
        _ if out.exists() && !args.force => {} // left to the export, which refuses it
        Format::Csv | Format::Parquet if out.is_file() => {
            let message = format!("{}: is a file; name a folder", out.display());
            return Err(BadInput(message).into());
        }
        Format::Csv | Format::Parquet => {} // made if it is not there
        Format::Npz | Format::GraphMl | Format::Dot | Format::MatrixMarket => {
            require_writable(Some(&out))?;
        }
    }
    let files = export::export(&source, format, &out, args.force).map_err(Error::from)?;
    for file in files {
        print(&format!("written to {}", file.display()));
    }
    Ok(Ending::Done)
}

/// Only a graph is one text.
fn to_stdout(source: &Source, format: Format) -> Result<Ending> {
    if !format.is_graph() {
        let message = "-o -: only graphml, dot and mtx can go to stdout; name a file or folder";
        return Err(BadInput(message.to_owned()).into());
    }
    let seed = source.only_seed().map_err(Error::from)?;
    let graph = seed.graph().map_err(Error::from)?;
    if std::io::stdout().is_terminal() {
        let mut text = Vec::new();
        export::write_graph(&mut text, &graph, format)?;
        print(&String::from_utf8_lossy(&text));
    } else {
        print_with(|out| export::write_graph(out, &graph, format));
    }
    Ok(Ending::Done)
}

fn format(choice: ExportFormat) -> Format {
    match choice {
        ExportFormat::Csv => Format::Csv,
        ExportFormat::Parquet => Format::Parquet,
        ExportFormat::Npz => Format::Npz,
        ExportFormat::Graphml => Format::GraphMl,
        ExportFormat::Dot => Format::Dot,
        ExportFormat::Mtx => Format::MatrixMarket,
    }
}

fn default_out(format: Format) -> PathBuf {
    PathBuf::from(match format {
        Format::Csv | Format::Parquet => "export",
        Format::Npz => "export.npz",
        Format::GraphMl => "graph.graphml",
        Format::Dot => "graph.dot",
        Format::MatrixMarket => "graph.mtx",
    })
}
