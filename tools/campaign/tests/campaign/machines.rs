#[test]
fn dumping() {
    let script: campaign::script::Script = std::fs::read_to_string("/tmp/script.txt").unwrap().parse().unwrap();
    campaign::prepare_twin(script.masters, false).unwrap();
    campaign::dump(&script);
}
