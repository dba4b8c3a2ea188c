//! Closures that have the objects of a node and use nothing but values.

use ecss_can::prelude::*;

/// A heater.
#[derive(Objects)]
#[objects(device)]
struct Heater {
    /// Power in percent
    #[object(0x6000, rw, pdo, high = 100)]
    power: u8,
}

impl Heater {
    fn off(&mut self) {
        self.power = 0;
    }
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::NONE;
}

struct Application<P: Platform> {
    heater: Handle<P, Slave<Heater>>,
    step: u8,
}

impl<P: Platform> Application<P> {
    /// A field beside the handle.
    fn run(&mut self) {
        self.heater.update(|objects| objects.power += self.step);
        self.heater.read(|objects| self.step = objects.power);
        self.heater.update(Heater::off);
    }
}

/// Any node with objects of a heater.
fn power<P: Platform, N: DeviceNode<Device = Heater>>(node: Handle<P, N>) -> u8 {
    node.read(|objects| objects.power)
}

fn main() {}
