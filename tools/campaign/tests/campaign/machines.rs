#[test]
fn dumping() {
    let text = std::fs::read_to_string("/tmp/run.txt").unwrap();
    let n: Vec<u64> = text.split_whitespace().map(|n| n.parse().unwrap()).collect();
    campaign::prepare_twin(n[0] as u8, false).unwrap();
    let script = campaign::script::Script::small(n[1], n[2], n[3]);
    let script = if n[0] == 2 { script.with_standby() } else { script };
    println!("{script}");
    campaign::dump(&script);
}
