//! Closures that have the objects of a node and use its handle.

use ecss_can::prelude::*;

/// A heater.
#[derive(Objects)]
#[objects(device)]
struct Heater {
    /// Power in percent
    #[object(0x6000, rw, pdo, high = 100)]
    power: u8,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[], &[CHANGE.transmit(1)]);
}

const CHANGE: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x180)).map(Heater::POWER);

fn slave<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.update(|objects| objects.power = heater.read(|objects| objects.power) + 1);
}

fn read<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.read(|_| heater.status());
}

fn filled<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.send_with(CHANGE, |_| heater.send(CHANGE));
}

fn master<P: Platform>(master: Handle<P, Master<Heater>>, node: NodeId) {
    master.active_errors(|_| master.reset(node));
}

struct Application<P: Platform> {
    heater: Handle<P, Slave<Heater>>,
    step: u8,
}

impl<P: Platform> Application<P> {
    fn next(&self) -> u8 {
        self.step
    }

    fn run(&self) {
        self.heater.update(|objects| objects.power = self.next());
    }
}

fn waiting<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    let wait = heater.wait_until(Instant::ZERO);
    heater.update(|_| drop(wait));
}

fn main() {}
