//! The twin knows no protocol above CAN: its sources do not name one.

use std::fs;
use std::path::Path;

const FOLDERS: [&str; 3] = ["twin/core/src", "twin/wire/src", "twin/board/src"];

/// Words of CANopen and of its extension, in small letters.
const WORDS: [&str; 9] =
    ["ecss", "canopen", "redundancy", "heartbeat", "node-id", "node_id", "emcy", "sdo", "pdo"];

/// Lines that have such a word, each with its place.
fn offences(name: &str, text: &str) -> Vec<String> {
    let lines = text.lines().zip(1..).flat_map(|(line, number)| {
        let line = line.to_lowercase();
        let found = WORDS.into_iter().filter(move |word| line.contains(word));
        found.map(move |word| format!("{name}:{number}: {word}"))
    });
    lines.collect()
}

/// Those of all files below a folder; counts the files.
fn offences_below(folder: &Path, files: &mut usize) -> Vec<String> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let found = paths.flat_map(|path| {
        if path.is_dir() {
            return offences_below(&path, files);
        }
        *files += 1;
        offences(&path.display().to_string(), &fs::read_to_string(&path).unwrap())
    });
    found.collect()
}

#[test]
fn the_twin_names_no_protocol_above_can() {
    let mut files = 0;
    let found = FOLDERS.map(|folder| offences_below(&crate::workspace().join(folder), &mut files)).concat();
    assert!(files > 100, "the sources are not where they are expected");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn words_of_the_protocol_are_found_in_any_letters() {
    let text = "/// Bits of the Node-ID.\nfn redundant_bus() {}\nstruct SdoClient;";
    assert_eq!(offences("pins.rs", text), ["pins.rs:1: node-id", "pins.rs:3: sdo"]);
}
