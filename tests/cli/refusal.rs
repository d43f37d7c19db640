//! How a refusal is judged: what it may do, what it must say.
//!
//! A case is a command line, the files it needs, and words that its message must hold. Each is run
//! twice, without and with an older output file, and judged by [`faults`].

use std::fmt::Write as _;

use crate::program::{Done, Folder};

/// A command line that must be refused.
pub(crate) struct Case {
    line: String,
    files: Vec<(&'static str, Vec<u8>)>,
    stdin: Vec<u8>,
    says: Vec<&'static str>,
}

pub(crate) fn case(line: impl Into<String>, says: &[&'static str]) -> Case {
    Case { line: line.into(), files: Vec::new(), stdin: Vec::new(), says: says.to_vec() }
}

impl Case {
    pub(crate) fn file(mut self, name: &'static str, content: impl AsRef<[u8]>) -> Self {
        self.files.push((name, content.as_ref().to_vec()));
        self
    }

    pub(crate) fn stdin(mut self, content: impl AsRef<[u8]>) -> Self {
        self.stdin = content.as_ref().to_vec();
        self
    }
}

/// Where the outputs of the cases go; the flag is added where a verb has it.
const OUTPUT: &str = "output";
pub(crate) const OLDER: &str = "an older result";

/// Words of which a message holds at least one, so that it says what to do.
const REMEDIES: [&str; 40] = [
    "a model is",
    "a scan has",
    "add ",
    "average",
    "belong to",
    "check ",
    "choose",
    "complete",
    "correct",
    "create",
    "crop",
    "delete",
    "described with",
    "export",
    "fill them with",
    "give",
    "is missing",
    "it has",
    "keep",
    "leave",
    "lift",
    "measure ",
    "move",
    "must be",
    "name ",
    "narrow",
    "needs --",
    "outside its domain, ",
    "possible values",
    "raise",
    "resample",
    "save",
    "say ",
    "set ",
    "the methods are",
    "try '--help'",
    "update",
    "use ",
    "widen",
    "write",
];

/// What is wrong with an answer.
pub(crate) fn faults(done: &Done, says: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let mut fault = |what: &str| found.push(what.to_owned());
    if done.code != Some(2) {
        fault(&format!("exit status {:?}, not 2", done.code));
    }
    if !done.out.is_empty() {
        fault("something is on stdout");
    }
    if done.err.contains("panicked") {
        fault("a panic");
    }
    let errors = done.err.lines().filter(|l| l.starts_with("error: ")).count();
    if errors != 1 {
        fault(&format!("{errors} lines start with `error: `"));
    }
    // Bad usage is answered by the parser of arguments in its own form.
    let usage = done.err.contains("try '--help'");
    if !usage && done.err.lines().count() > 2 {
        fault("more than two lines");
    }
    if done.err.len() > 1000 {
        fault(&format!("{} bytes long", done.err.len()));
    }
    if done.err.starts_with("error: ") && !usage && done.err.contains(" \n") {
        fault("a blank at the end");
    }
    if done.err.chars().any(|c| c.is_control() && c != '\n') {
        fault("control characters reach the terminal");
    }
    if !REMEDIES.iter().any(|word| done.err.contains(word)) {
        fault("no word of what to do");
    }
    for word in says {
        if !done.err.contains(word) {
            fault(&format!("`{word}` is not said"));
        }
    }
    found
}

/// Runs all cases and reports all faults together.
#[track_caller]
pub(crate) fn refused(cases: Vec<Case>) {
    let mut report = String::new();
    let count = cases.len();
    for case in cases {
        for older in [false, true] {
            let folder = prepared(&case);
            let verb = case.line.split_whitespace().next().unwrap_or_default();
            let writes = ["model", "scan", "fit", "eval"].contains(&verb);
            let line = if writes && !case.line.contains(" -o ") {
                if older {
                    folder.write(OUTPUT, OLDER);
                }
                format!("{} -o {OUTPUT}", case.line)
            } else {
                case.line.clone()
            };
            let before = folder.content();
            let done = folder.pipe(&line, &case.stdin);
            let mut found = faults(&done, &case.says);
            if folder.content() != before {
                found.push(format!("the folder has changed: {:?}", folder.names()));
            }
            if !found.is_empty() {
                let line = line.escape_debug().to_string();
                let faults = found.join("; ");
                let shown: String = done.err.chars().take(400).collect();
                let _ = writeln!(report, "asperity {line}\n  {faults}\n  stderr: {shown:?}");
                break;
            }
        }
    }
    assert!(report.is_empty(), "of {count} cases these are answered wrongly:\n{report}");
}

/// A folder with good inputs, and the files of the case.
fn prepared(case: &Case) -> Folder {
    let folder = Folder::new();
    folder.write("scan.csv", SCAN);
    folder.write("foreign.csv", FOREIGN);
    folder.write("m.json", MODEL);
    folder.write("opaque.json", OPAQUE);
    std::fs::create_dir(folder.path("folder")).expect("a folder");
    for (name, content) in &case.files {
        folder.write(name, content);
    }
    folder
}

pub(crate) const SCAN: &str = "\
# sample: frosted acrylic
# geometry: transmission
# ior: 1.49
# rough_side: source
# aperture_deg: 0.6
sigma_deg,theta_deg,reading
0,-10,1.1e-4
0,-5,3.0e-4
0,0,6.0e-4
0,5,3.0e-4
0,10,1.1e-4
30,20,1.2e-4
30,30,5.0e-4
30,40,1.0e-4
";

pub(crate) const FOREIGN: &str = "\
surface,in,out,brdf
steel,0,-10,0.1
steel,0,0,0.9
steel,0,10,0.1
steel,0,20,nan
paint,0,0,0.3
paint,0,0,0.4
";

pub(crate) const MODEL: &str = r#"{
  "asperity": 1,
  "method": "ggx",
  "ior": 1.49,
  "parameters": {
    "alpha": { "value": 0.2 }
  }
}
"#;

pub(crate) const OPAQUE: &str = r#"{
  "asperity": 1,
  "method": "ggx",
  "body": "opaque",
  "parameters": {
    "alpha": { "value": 0.2 },
    "gain": { "value": 0.5 },
    "lambert": { "value": 0.01 }
  }
}
"#;
