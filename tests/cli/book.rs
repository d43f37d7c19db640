//! The commands of the user guide, run in the order of its pages in one folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{Folder, program};

fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("docs").join("book/src")
}

/// Pages in the order of the summary.
fn pages() -> Vec<PathBuf> {
    let summary = fs::read_to_string(book().join("SUMMARY.md")).unwrap();
    let links = summary.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(path, _)| book().join(path)).collect()
}

/// The blocks of a page that are marked as shell.
fn commands(page: &str) -> Vec<String> {
    let blocks = page.split("\n```sh\n").skip(1).filter_map(|rest| rest.split_once("\n```"));
    blocks.map(|(block, _)| block.to_owned()).collect()
}

#[test]
#[cfg(unix)]
fn every_command_of_the_guide_runs() {
    let folder = Folder::new();
    let bin = folder.path("bin");
    fs::create_dir(&bin).unwrap();
    std::os::unix::fs::symlink(program(), bin.join("asperity")).unwrap();
    let path = std::env::join_paths(
        std::iter::once(bin).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let path = path.unwrap();
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for block in commands(&text) {
            let mut shell = Command::new("sh");
            shell.args(["-ec", &block]).current_dir(folder.path("")).env("PATH", &path);
            let out = shell.output().unwrap();
            let said = String::from_utf8_lossy(&out.stderr);
            assert!(out.status.success(), "{}:\n{block}\n{said}", page.display());
            count += 1;
        }
    }
    assert!(count >= 10, "{count} blocks only");
}
