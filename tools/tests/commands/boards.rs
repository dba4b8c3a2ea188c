//! Boards of the user: a description instead of a name, or a part and an oscillator without a file.

use std::fs;
use std::path::PathBuf;

use second::programs::boards::description;
use tempfile::TempDir;

use crate::{TOOLS, assert_refused};

/// Images of the pyboard as images of the user's, and a folder for the results.
struct Own {
    out: TempDir,
    master: PathBuf,
    slave: PathBuf,
}

impl Own {
    fn new() -> Own {
        let images = ecss_can_cli::images::build("pyboard-v11", "standard").expect("images");
        let out = tempfile::tempdir().expect("a temporary directory");
        Own { out, master: images.master, slave: images.slave }
    }

    /// Returns the same images without the symbol that identifies their chip.
    fn without_chip() -> Own {
        const SYMBOL: &[u8] = b"__device_id";
        let Own { out, master, slave } = Own::new();
        let folder = out.path().join("images");
        fs::create_dir(&folder).expect("a folder");
        let [master, slave] = [(master, "master"), (slave, "slave")].map(|(path, name)| {
            let mut elf = fs::read(path).expect("an image");
            let place = elf.windows(SYMBOL.len()).position(|bytes| bytes == SYMBOL).expect("the symbol");
            elf[place] = b'X';
            let path = folder.join(name);
            fs::write(&path, elf).expect("a file");
            path
        });
        Own { out, master, slave }
    }

    /// Runs `cargo demo` of a master and a slave for 3 s, with these options.
    fn fly(&self, options: &[&str]) -> (i32, String) {
        let (master, slave) = (self.master.display().to_string(), format!("2={}", self.slave.display()));
        let out = self.out.path().display().to_string();
        let own = ["fly", "--slaves", "0", "--master", &master, "--slave", &slave, "--out", &out];
        let flight = [&own[..], &["--seconds", "3", "--cut-at", "never"], options].concat();
        let (code, stdout, stderr) = TOOLS.run(&flight);
        (code, stdout + &stderr)
    }

    /// Checks that a flight fails for these reasons.
    fn fails(&self, options: &[&str], reasons: &[&str]) {
        let (code, text) = self.fly(options);
        assert_eq!(code, 1, "{options:?}: {text}");
        let (_, error) = text.split_once("error: the run failed").expect("an error");
        assert!(reasons.iter().all(|reason| error.contains(reason)), "{reasons:?}: {error}");
    }
}

/// Given one mistake in a description, then each command with `--board` refuses it and names file, field and allowed
/// values.
#[test]
fn mistakes_in_a_description_are_refused() {
    for (from, to, parts) in [
        ("12MHz", "120MHz", &["oscillator.frequency", "120MHz", "4MHz to 26MHz"][..]),
        ("STM32F405RG", "STM32F413VG", &["chip", "STM32F413VG", "three bxCAN", "STM32F446"]),
        ("PB8", "PD0", &["can1.rx", "PD0", "no such pin", "64 pins"]),
        ("PA6", "PA5", &["straps.parity", "PA5", "straps.bits[3] has this pin"]),
        ("parity", "parities", &["unknown field `parities`", "`parity`"]),
    ] {
        let (_folder, path) = description(&[(from, to)]);
        TOOLS.refuses(&["fly", "--board", &path], &[parts, &["--board", &path]].concat());
    }
    let (_folder, path) = description(&[("PA6", "PA99")]);
    for command in ["fly", "twin"] {
        TOOLS.refuses(&[command, "--board", &path], &["straps.parity", "PA99", "PA0 to PK15"]);
    }
}

/// Given a good description without the crate of its board beside it, then commands that would build images refuse it
/// and name the supported boards.
#[test]
fn images_are_not_built_for_a_board_without_crate() {
    let (folder, path) = description(&[("pyboard-v11", "mine")]);
    let folder = folder.path().to_str().expect("UTF-8");
    for command in ["fly", "twin"] {
        for board in [&path, folder] {
            let said = ["no Cargo.toml", folder, "pyboard-v11, nucleo-f446re", "Cargo.toml and board.toml"];
            TOOLS.refuses(&[command, "--board", board], &said);
        }
    }
}

#[test]
fn wrong_parts_and_oscillators_are_refused() {
    assert_refused(&[
        ("fly --chip STM32F412VG", &["--chip", "STM32F412VG", "100 MHz", "STM32F407"]),
        ("twin --chip STM32F407RG", &["--chip", "no package", "V (100 pins)"]),
        ("twin --oscillator 80MHz", &["--oscillator", "80MHz", "4MHz to 26MHz"]),
        ("fly --chip STM32F407VG", &["--chip is for images of your own", "--slave N=FILE"]),
        ("twin --oscillator 8MHz", &["--oscillator is for images of your own"]),
    ]);
    TOOLS.refuses(&["fly", "--oscillator", "8MHz quartz"], &["--oscillator", "crystal", "external"]);
    let (_folder, path) = description(&[
        ("pyboard-v11", "mine"),
        ("STM32F405RG", "STM32F407VG"),
        ("PB8", "PD0"),
        ("PB9", "PD1"),
    ]);
    let arguments = ["fly", "--slaves", "0", "--master", "a", "--slave", "2=b", "--board", &path];
    TOOLS.refuses(&[&arguments[..], &["--chip", "STM32F446RE"]].concat(), &["--chip", "STM32F446RE", "PD0"]);
}

/// Given images of the user, then they run on parts that no board of the project has: by a description, or by `--chip`
/// with the pins of the pyboard. Images that do not identify their chip run on each part.
#[test]
fn own_images_fly_on_other_parts() {
    let own = Own::new();
    let unnamed = Own::without_chip();
    for (own, chip) in [(&own, "STM32F407VG"), (&unnamed, "STM32F429ZI"), (&unnamed, "STM32F469NI")] {
        let (code, text) = own.fly(&["--chip", chip]);
        assert_eq!(code, 0, "{chip}: {text}");
        let summary = fs::read_to_string(own.out.path().join("summary.json")).expect("a summary");
        assert!(summary.contains(&format!("\"pyboard-v11 with {chip}, 12 MHz\"")), "{summary}");
    }
    let changes = [("pyboard-v11", "mine"), ("STM32F405RG", "STM32F407IG"), ("PA3", "PH3"), ("PA6", "PI11")];
    let (_folder, path) = description(&changes);
    let (code, text) = own.fly(&["--board", &path]);
    assert_eq!(code, 1, "the image looks for its straps at other pins: {text}");
    let reason = "node 2 is starting on the nominal bus at the end; its log: no Node-ID by straps and store: Missing, staying silent";
    assert!(text.contains(reason), "{text}");
    let changes = [("pyboard-v11", "mine"), ("STM32F405RG", "STM32F415ZG")];
    let (_folder, path) = description(&changes);
    let (code, text) = own.fly(&["--board", &path]);
    assert_eq!(code, 0, "{text}");
}

/// Given an image for a NUCLEO, when it is used on a pyboard, then it is refused before the flight, by each command and
/// with both chips; so is an image of a pyboard on a part of another family.
#[test]
fn images_for_another_chip_are_refused() {
    let nucleo =
        ecss_can_cli::images::build("nucleo-f446re", "standard").expect("images").slave.display().to_string();
    let slave = format!("3={nucleo}");
    let said =
        [&*nucleo, "the image was linked for DEV_ID 421h (STM32F446), the board has an STM32F405RG (413h)"];
    TOOLS.refuses(&["fly", "--slave", &slave], &said);
    TOOLS.refuses(&["twin", "--slave", &slave], &said);
    TOOLS.refuses(&["fly", "--master", &nucleo], &said);
    let own = Own::new();
    let (code, text) = own.fly(&["--chip", "STM32F429ZI"]);
    assert_eq!(code, 2, "{text}");
    assert!(
        text.contains("linked for DEV_ID 413h") && text.contains("the board has an STM32F429ZI (419h)"),
        "{text}"
    );
}

/// Given images for a crystal of 12 MHz, when their boards have another one, then the flight fails and names oscillator
/// and HCLK: with a slower one all clocks of the boards agree with each other, and their bit rate is not in CiA 301.
#[test]
fn frequency_of_another_oscillator_fails_the_flight() {
    let own = Own::new();
    let slow = "node 2: CAN2 runs at 666.7 kbit/s, which is no bit rate of CiA 301: HCLK is 112 MHz, and the oscillator of the board \
                has 8 MHz";
    let fast = "HCLK, PCLK1 or PCLK2 would be faster than the part allows";
    for (oscillator, reasons) in
        [("8MHz", [slow, "master: CAN2 runs at"]), ("16MHz", [fast, "check the PLL"])]
    {
        own.fails(&["--oscillator", oscillator], &reasons);
    }
}

/// Given images that have CAN1 at PB8 and PB9 on a board with its transceiver at PD0 and PD1, then the redundant bus
/// works, and the flight fails because of the pins.
#[test]
fn transceiver_at_other_pins_fails_the_flight() {
    let changes = [
        ("pyboard-v11", "mine"),
        ("STM32F405RG", "STM32F407VG"),
        ("\"PB8\"", "\"PD0\""),
        ("\"PB9\"", "\"PD1\""),
    ];
    let (_folder, path) = description(&changes);
    let reasons = ["master", "node 2"].map(|node| {
        format!(
            "{node}: CAN1 takes part in no bus: PB8 carries CAN1_RX, and the board has the transceiver at PD0"
        )
    });
    Own::new().fails(&["--board", &path], &reasons.each_ref().map(String::as_str));
}

/// Given a board whose wire from CAN_RX ends at another pin than the image captures at, then the flight fails and names both pins.
#[test]
fn capture_wire_at_another_pin_fails_the_flight() {
    let changes = [("pyboard-v11", "mine"), ("\"PA2\"", "\"PC2\""), ("\"PA0\"", "\"PA2\"")];
    let (_folder, path) = description(&changes);
    let reason = "master: TIM5 captures at PA0, and the board has the wire from CAN1_RX at PA2";
    Own::new().fails(&["--board", &path], &[reason]);
}

/// Given a slave for 125 kbit/s among boards for 1 Mbit/s, then the first reason of the failure is the bit rates, with all boards.
#[test]
fn different_bit_rates_are_the_first_reason_of_the_failure() {
    let slave = ecss_can_cli::images::build("pyboard-v11", "standard+kbit-125").expect("images").slave;
    let (code, text) = Own { slave, ..Own::new() }.fly(&[]);
    assert_eq!(code, 1, "{text}");
    let reason = "error: the run failed: the bit rates on the nominal bus differ: node 2 at 125 kbit/s; master at 1000 kbit/s";
    assert!(text.contains(reason), "{text}");
}

/// Given an image for a crystal, when its board has an external clock, then the oscillator does not start, and the
/// flight fails.
#[test]
fn wrong_oscillator_of_an_own_board_fails_the_flight() {
    Own::new().fails(&["--oscillator", "12MHz external"], &["HSE does not start"]);
}
