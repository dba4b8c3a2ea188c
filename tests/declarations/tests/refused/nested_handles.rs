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
    const PDOS: PdoSet = PdoSet::NONE;
}

fn slave<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.update(|objects| objects.power = heater.read(|objects| objects.power) + 1);
}

fn read<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.read(|_| heater.status());
}

fn filled<P: Platform>(heater: Handle<P, Slave<Heater>>) {
    heater.send_pdo_with(0, |_| heater.send_pdo(1));
}

fn master<P: Platform>(master: Handle<P, Master<Heater>>, node: NodeId) {
    let _ = master.send_pdo_to(node, 0, |objects| objects.power = u8::from(master.is_active()));
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
