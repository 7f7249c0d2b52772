//! The page about the figures: pictures, captions and commands in one file that fetches nothing.

use super::counterparts::Figure;
use super::escaped;
use crate::report::marker::MARKER;
use std::fmt::Write;

const STYLE: &str = "
:root{color-scheme:light dark}
body{margin:0 auto;max-width:1100px;padding:28px 20px 60px;font:16px/1.55 system-ui,-apple-system,'Segoe UI',Helvetica,Arial,sans-serif;background:#f6f8fa;color:#1f2328}
h1{font-size:32px;letter-spacing:-.02em;margin:0 0 6px}figure{margin:26px 0;padding:22px 26px;background:#fff;border:1px solid #d8dee4;border-radius:10px}
svg{display:block;max-width:100%;height:auto;margin:0 auto}figcaption{margin-top:14px}code{font-size:13px;color:#59636e}
@media(prefers-color-scheme:dark){body{background:#0d1117;color:#f0f6fc}figure{background:#151b23;border-color:#30363d}code{color:#a3acb6}}
@media(max-width:600px){figure{padding:14px}body{padding:18px 12px}h1{font-size:26px}code{overflow-wrap:anywhere}}
";

/// The page, for a folder that holds each picture as `fig4.svg`, `fig5.svg` … too.
pub fn figures_page(figures: &[Figure]) -> String {
    let mut body = String::new();
    for figure in figures {
        let (number, caption) = (figure.number, escaped(&figure.caption));
        let commands: Vec<String> = (figure.scenarios.iter())
            .map(|name| format!("<code>eigentrail run scenarios/report/{name}.toml</code>"))
            .collect();
        let _ = writeln!(
            body,
            "<figure>\n{}<figcaption><b>Figure {number}.</b> {caption}<br>{}</figcaption>\n</figure>",
            figure.svg,
            commands.join("<br>")
        );
    }
    format!(
        r#"<!doctype html>
{MARKER}
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>Figures 4 to 9 · eigentrail</title>
<style>{STYLE}</style>
</head>
<body>
<h1>Figures 4 to 9, from our own runs</h1>
<p>Counterparts of the figures of <i>Sparse Reward Propagation for Deep Reinforcement Learning</i>, made by
<code>eigentrail figures --all</code>. The pictures stand beside this page as <code>fig4.svg</code> to <code>fig9.svg</code>.</p>
{body}</body>
</html>
"#
    )
}
