use std::sync::Arc;

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::Crystal;
use can_twin::image::Image;
use can_twin::model::Model;
use can_twin::spacecraft::SpacecraftConfig;

use super::*;

/// Boards at 0 m (node 1), 10 m (node 2) and 20 m (node 3), and the node of the clients at 30 m. Their program is an endless loop.
fn flown() -> (Operator, Spacecraft) {
    const PROGRAM: [u8; 10] = [0x00, 0x00, 0x02, 0x20, 0x09, 0x00, 0x00, 0x08, 0xFE, 0xE7];
    let image = Arc::new(Image::from_flash(PROGRAM.to_vec()));
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let mut board = |node: Node| {
        let config = BoardConfig {
            name: format!("node {node}"),
            model: Model::shipped("pyboard-v11"),
            image: image.clone(),
            straps: Vec::new(),
            crystal: Crystal::ppm(0.0),
            position_m: f64::from(node - 1) * 10.0,
            power_on_at: Time::ZERO,
            fittings: Fittings::default(),
        };
        (node, spacecraft.add_board(config))
    };
    let boards = [1, 2, 3].map(&mut board).into();
    spacecraft.run_until(Time::from_us(10)).expect("it flies");
    (Operator::new(boards, vec![30.0]), spacecraft)
}

fn said(line: &str, (operator, spacecraft): &mut (Operator, Spacecraft)) -> Result<String, String> {
    let said = operator.obey(line, spacecraft);
    let next = spacecraft.now() + Time::from_us(10);
    spacecraft.run_until(next).expect("it flies");
    said
}

fn answers(lines: &[(&str, Result<&str, &str>)]) {
    let mut flown = flown();
    for (line, expected) in lines {
        let said = said(line, &mut flown);
        match (&said, expected) {
            (Ok(said), Ok(part)) | (Err(said), Err(part)) => assert!(said.contains(part), "{line}: {said}"),
            _ => panic!("{line}: {said:?}"),
        }
    }
}

/// Given a break with all nodes on one side of it, then it is refused with the places of the nodes.
#[test]
fn cut_that_separates_nothing_is_refused() {
    let said = Err("separates nothing: the nodes of the nominal bus are between 0.0 m and 30.0 m");
    answers(&[
        ("cut nominal 0", said),
        ("cut nominal 30.5", said),
        ("cut nominal 1000", said),
        ("heal nominal", Ok("already whole")),
        ("cut nominal 0.1", Ok("done")),
        ("cut redundant 30", Ok("done")),
    ]);
}

#[test]
fn cut_without_node_up_to_another_one_is_no_cut() {
    answers(&[
        ("cut nominal 11", Ok("done")),
        ("cut nominal 20", Ok("already cut at 11 m, and no node is between")),
        ("cut nominal 10.5", Ok("already cut at 11 m")),
        ("cut nominal 20.5", Ok("done")),
        ("heal nominal 20", Ok("already whole at 20 m")),
        ("heal nominal 11", Ok("done")),
        ("cut nominal 20", Ok("done")),
    ]);
}

/// Given a short of a piece of cable, then a second short with the same level changes nothing, until a break makes two
/// pieces.
#[test]
fn second_short_of_a_piece_changes_its_level_or_nothing() {
    answers(&[
        ("short nominal 0", Ok("done")),
        ("short nominal 25 dominant", Ok("already shorted at 0 m, dominant")),
        ("short nominal 25 recessive", Ok("done")),
        ("short nominal 0 recessive", Ok("already shorted at 25 m, recessive")),
        ("cut nominal 15", Ok("done")),
        ("short nominal 0 recessive", Ok("done")),
        ("clear nominal", Ok("done")),
        ("clear nominal", Ok("already")),
    ]);
}

#[test]
fn board_without_power_takes_no_fault() {
    let off = Err("node 2 has no power: power 2 on");
    answers(&[
        ("power 2 off", Ok("done")),
        ("power 2 off", Ok("already off")),
        ("reset 2", off),
        ("babble 2 nominal 080#", off),
        ("flip nominal 12 3 2", off),
        ("quiet 2 nominal", Ok("already quiet")),
        ("power 2 on", Ok("done")),
        ("babble 2 nominal 080#", Ok("done")),
    ]);
}

#[test]
fn nodes_that_do_not_fly_are_refused() {
    let none = Err("there is no node 4: allowed are 1, 2, 3");
    answers(&[
        ("power 4 off", none),
        ("reset 4", none),
        ("flip nominal 12 4", none),
        ("babble 4 nominal 080#", none),
        ("quiet 4 nominal", none),
    ]);
}

/// Longest frame of 8 data bytes with an 11-bit identifier: 132 bits.
#[test]
fn bit_that_usual_frames_lack_is_pointed_out() {
    answers(&[
        ("flip nominal 131", Ok("done")),
        ("flip nominal 132", Ok("only a frame with a 29-bit identifier")),
    ]);
    assert_eq!(said("flip nominal 131", &mut flown()).unwrap(), "done");
}
