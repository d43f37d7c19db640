//! Help that teaches, the version, tab completions.

use crate::program::Folder;

#[test]
fn every_verb_explains_itself_and_names_its_flags() {
    let folder = Folder::new();
    for (verb, flags, lesson) in [
        ("demo", "--output --rays --json", "the truth is known"),
        (
            "model",
            "<METHOD> --set --ior --opaque --profile --map --seed --output --json",
            "Examples:\n  asperity model normals",
        ),
        (
            "scan",
            "[MODEL] --map --engine --ior --pixel-um --fill --edges --sigma --theta-range --step --aperture --geometry --rough-side --quantity \
             --rays --seed --output --json",
            "internal passes",
        ),
        (
            "fit",
            "<SCAN> --method --objective --profile --fit-theta0 --fit-n --fit-h-max --fit-z0 --map \
             --no-cutoff --rays --fit-rays --seed --pixel-um --z-um --crop --fill --form --edges --fit-ior --fit-gain \
             --max-evaluations --max-misfit --output --plot --json --ior --opaque --geometry \
             --rough-side --aperture --columns --quantity --where --delimiter --decimal-comma \
             --skip-missing --sigma-range --theta-range",
            "Examples:\n  asperity fit scan.csv",
        ),
        (
            "compare",
            "<SCAN>... --map --methods --output --json --objective --rays --fit-rays --seed \
             --max-evaluations --max-misfit --ior --opaque --aperture --pixel-um --fill --edges --columns",
            "Table 2",
        ),
        (
            "trade",
            "<SCAN|MODEL>... --map --methods --table-kib --table-rays --max-error --firmware --csv --plot --json --ior --rays --columns",
            "--table-kib 2,8,32",
        ),
        (
            "plan",
            "[SCENE] --example --output --report --trade --check --seed --json",
            "--example light-guide > scene.toml",
        ),
        (
            "plot",
            "<FILE>... --output --view --incidence --side --linear --decades --title --rays --sigma-range --pixel-um",
            "asperity plot fit.json -o boundary",
        ),
        (
            "render",
            "[MODEL]... --model --scene --scene-example --output --size --paths --until --quick --reference --white --regions --shard --export --json --rays --seed",
            "asperity render fit.json -o fit.png",
        ),
        ("eval", "<MODEL> --input --output --rays --seed --json", "wix,wiy,wiz,wox,woy,woz"),
        (
            "check",
            "[MODEL] --map --engine --ior --incidence --side --rays --seed --json --profile --period-um --incidence-orders --orders --output",
            "R + T > 1",
        ),
        (
            "stats",
            "<MAP> --pixel-um --z-um --crop --fill --form --edges --plot --json",
            "asperity stats map.x3p --fill harmonic",
        ),
        (
            "acquire",
            "--port --baud --schedule --sigma --theta-range --step --aperture --integration-ms --range --run-up \
             --calibrate --geometry --sample --ior --rough-side --wavelength-nm --output --credit --resume \
             --recalibrate --dry-run --list-ports --json",
            "asperity acquire --port /dev/ttyUSB0 -o scan.csv --resume",
        ),
        ("instrument", "status home stop clear", "asperity instrument status --port"),
        ("completions", "<SHELL>", "asperity completions bash >"),
    ] {
        let done = folder.run(&format!("{verb} --help")).with_code(0);
        assert!(done.err.is_empty(), "{verb}: {}", done.err);
        for flag in flags.split_whitespace() {
            assert!(done.out.contains(flag), "{verb}: {flag} is not in\n{}", done.out);
        }
        assert!(done.out.contains(lesson), "{verb}: no lesson in\n{}", done.out);
        let short = folder.run(&format!("{verb} -h")).ok();
        assert!(short.lines().count() <= done.out.lines().count(), "{verb}");
        // every verb is listed with a line of its own
        let all = folder.run("--help").ok();
        assert!(all.lines().any(|l| l.trim_start().starts_with(&format!("{verb} "))), "{verb}");
    }
}

#[test]
fn the_help_of_the_program_has_examples_and_the_exit_statuses() {
    let folder = Folder::new();
    let help = folder.run("--help").ok();
    for words in ["Examples:", "asperity demo", "degrees", "Exit status: 0 done, 1", "2 bad usage"]
    {
        assert!(help.contains(words), "{words} is not in\n{help}");
    }
    assert_eq!(folder.run("help").ok(), help);
}

#[test]
fn the_version_is_the_workspaces() {
    let folder = Folder::new();
    let expected = format!("asperity {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(folder.run("--version").ok(), expected);
    assert_eq!(folder.run("-V").ok(), expected);
}

#[test]
fn no_arguments_are_answered_with_the_usage() {
    let done = Folder::new().run("").with_code(2);
    assert!(done.out.is_empty(), "{}", done.out);
    assert!(done.err.contains("Usage: asperity [OPTIONS] <COMMAND>"), "{}", done.err);
}

#[test]
fn completions_know_verbs_and_flags() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish"] {
        let text = folder.run(&format!("completions {shell}")).ok();
        for word in ["asperity", "model", "scan", "check", "max-evaluations"] {
            assert!(text.contains(word), "{shell}: {word} is missing");
        }
    }
}
