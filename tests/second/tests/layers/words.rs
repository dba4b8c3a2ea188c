//! The twin implements no protocol above CAN, and its sources do not name one.

use second::tools::files;

const FOLDERS: [&str; 1] = ["twin/src"];

/// Words of CANopen and of its extension, in lower case.
const WORDS: [&str; 9] =
    ["ecss", "canopen", "redundancy", "heartbeat", "node-id", "node_id", "emcy", "sdo", "pdo"];

/// Link to a package of the same family.
const LINK: &str = "](https://docs.rs/";

/// Returns lines with such a word, each with its place. A line of links to related packages is none.
fn offences(name: &str, text: &str) -> Vec<String> {
    let lines = text.lines().zip(1..).filter(|(line, _)| !line.contains(LINK)).flat_map(|(line, number)| {
        let line = line.to_lowercase();
        let found = WORDS.into_iter().filter(move |word| line.contains(word));
        found.map(move |word| format!("{name}:{number}: {word}"))
    });
    lines.collect()
}

#[test]
fn the_twin_names_no_protocol_above_can() {
    let files = FOLDERS.map(|folder| files(&crate::workspace().join(folder), "rs")).concat();
    assert!(files.len() > 100, "the sources are not where they are expected");
    let found = files.iter().flat_map(|(path, text)| offences(&path.display().to_string(), text));
    let found: Vec<String> = found.collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn words_of_the_protocol_are_found_in_any_letters() {
    let text = "/// Bits of the Node-ID.\nfn redundant_bus() {}\nstruct SdoClient;";
    assert_eq!(offences("pins.rs", text), ["pins.rs:1: node-id", "pins.rs:3: sdo"]);
}
