//! Part of the software of a symbol, by its path.

/// Modules of the protocol crates. Each is a separate part.
pub const PROTOCOL: [&str; 16] = [
    "types",
    "link",
    "od",
    "time",
    "nmt",
    "heartbeat",
    "sync",
    "emcy",
    "sdo",
    "pdo",
    "store",
    "redundancy",
    "boot",
    "profile",
    "node",
    "runner",
];

/// Crates, and the part that they belong to. A crate that is not listed counts as `others`.
const CRATES: [(&str, &str); 17] = [
    ("ecss_can_stm32f4", "boards"),
    ("ecss_can_runtime", "boards"),
    ("pyboard_v11", "boards"),
    ("nucleo_f446re", "boards"),
    ("mission", "application"),
    ("master", "application"),
    ("slave", "application"),
    ("minimal", "application"),
    ("core", "core"),
    ("compiler_builtins", "core"),
    ("memcpy", "core"),
    ("memset", "core"),
    ("defmt", "log"),
    ("defmt_rtt", "log"),
    ("_defmt_write", "log"),
    ("_embassy_time_schedule_wake", "embassy"),
    ("crc", "boards"),
];

/// The parts in addition to the protocol. `others`: vectors, constants, small crates.
const BESIDE: [&str; 6] = ["application", "boards", "embassy", "core", "log", "others"];

/// Prefixes around the future of a task.
const WRAPPERS: [&str; 2] =
    ["<embassy_executor::raw::TaskStorage<", "ecss_can_stm32f4::supervisor::Supervised<"];

/// Returns all parts, in the order of their rows.
pub fn parts() -> impl Iterator<Item = &'static str> {
    PROTOCOL.into_iter().chain(BESIDE)
}

/// Returns the part of a function or constant.
///
/// A method belongs to the part of its type. An implementation of a trait of the object dictionary belongs to the
/// dictionary, regardless of the objects. The compiler inlines the tasks of the runner into the one-line tasks of an
/// image.
pub fn part(name: &str) -> &'static str {
    if ["::app::__bus_task", "::app::__due_task"].iter().any(|task| name.contains(task)) {
        return "runner";
    }
    let wrapped = WRAPPERS.iter().find_map(|wrapper| name.strip_prefix(wrapper));
    if let Some(task) = wrapped {
        return part(task);
    }
    if name.contains(" as async_canopen::od::") {
        return "od";
    }
    let path = name.trim_start_matches(['<', '&', '*', '[', '(']);
    let path = path.strip_prefix("mut ").unwrap_or(path);
    let mut words = path.split(['<', '>', ' ', ':', '(', '[']).filter(|word| !word.is_empty());
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    if ["async_canopen", "ecss_can"].contains(&first) {
        return PROTOCOL.into_iter().find(|module| *module == second).unwrap_or("others");
    }
    if first.starts_with("embassy_") || first == "stm32_metapac" {
        return "embassy";
    }
    CRATES.iter().find(|(name, _)| *name == first).map_or("others", |(_, part)| part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbol_belongs_to_the_module_of_its_type() {
        for (name, expected) in [
            ("<ecss_can::node::slave::Slave<mission::objects::MissionObjects<&mut [u8]>>>::run_due", "node"),
            (
                "<async_canopen::sdo::server::Server>::go_on::<ecss_can::node::device::dictionary::Dictionary<A>>",
                "sdo",
            ),
            ("async_canopen::pdo::mapping::read::<ecss_can::node::objects::NodeObjects<mission::A>>", "pdo"),
            (
                "<ecss_can::node::objects::NodeObjects<A> as async_canopen::od::dictionary::Objects>::variable",
                "od",
            ),
            (
                "<ecss_can_stm32f4::bxcan::port::Port<ecss_can_stm32f4::capture::Edges> as async_canopen::link::port::CanPort>::stamp",
                "boards",
            ),
            ("mission::objects::communication::<async_canopen::pdo::parameters::PdoMapping>", "application"),
            (
                "<embassy_executor::raw::TaskStorage<slave::app::____embassy_main_task::f::{closure#0}>>::poll",
                "application",
            ),
            (
                "<embassy_executor::raw::TaskStorage<ecss_can_stm32f4::supervisor::Supervised<<master::application::Application<A>>::run::{closure#0}>>>::poll",
                "application",
            ),
            ("<embassy_executor::raw::TaskStorage<slave::app::__bus_task::f::{closure#0}>>::poll", "runner"),
            ("embassy_stm32::init", "embassy"),
            ("<core::fmt::Formatter>::pad", "core"),
            ("<u32 as core::fmt::Display>::fmt", "others"),
            ("__INTERRUPTS", "others"),
        ] {
            assert_eq!(part(name), expected, "{name}");
            assert!(parts().any(|part| part == expected));
        }
    }
}
