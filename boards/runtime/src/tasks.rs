//! Tasks of an image: the tasks of a node on two buses, and the task of its pulse output.

/// Declares a function that spawns the tasks of a node: `fn NAME(BOARD, NODE)`, with the types of its board and its
/// node. The function takes a `Spawner` and the `Runners` of the node. Tasks of Embassy cannot be generic, so each
/// image declares its own.
///
/// The tasks are supervised under the names `bus`, twice, and `due`. With the feature `program` of this crate the function also
/// spawns the task that checks the program in flash. The image depends on `ecss-can` and `embassy-executor`.
///
/// ```ignore (a part of an image)
/// ecss_can_runtime::node_tasks!(fn spawn_node(Board, Slave<Heater>));
///
/// // In its main task:
/// let (slave, events, runners) = RESOURCES.start(slave, board.connection, &DIAGNOSTICS);
/// spawn_node(spawner, runners);
/// ```
#[macro_export]
macro_rules! node_tasks {
    (fn $name:ident($board:ty, $node:ty)) => {
        fn $name(spawner: ::embassy_executor::Spawner, runners: ::ecss_can::runner::Runners<$board, $node>) {
            #[::embassy_executor::task(pool_size = 2)]
            fn bus(runner: ::ecss_can::runner::BusRunner<$board, $node>) -> impl Future<Output = ()> {
                $crate::supervised("bus", runner.run())
            }

            #[::embassy_executor::task]
            fn due(runner: ::ecss_can::runner::DueRunner<$board, $node>) -> impl Future<Output = ()> {
                $crate::supervised("due", runner.run())
            }

            spawner.spawn(bus(runners.nominal).unwrap());
            spawner.spawn(bus(runners.redundant).unwrap());
            spawner.spawn(due(runners.due).unwrap());
            $crate::spawn_check(spawner);
        }
    };
}

/// Declares a function that spawns the task of the pulse output: a pulse at each second of the spacecraft time, or at equal parts of
/// it. The function takes a `Spawner`, the `Pulse` of the board and the handle of the node.
///
/// `fn NAME(BOARD, NODE, PER_SECOND)`: types of board and node, and a function that takes the handle of the node and returns the
/// number of pulses per second as a function, which the task calls before each pulse. The task is supervised under the name `pulses`. The image
/// depends on `ecss-can`, `ecss-can-stm32f4` and `embassy-executor`.
///
/// ```ignore (a part of an image)
/// ecss_can_runtime::pulse_task!(fn spawn_pulses(Board, Node, pulses_per_second));
///
/// // In its main task:
/// spawn_pulses(spawner, board.pulse, slave);
/// ```
#[macro_export]
macro_rules! pulse_task {
    (fn $name:ident($board:ty, $node:ty, $per_second:path)) => {
        fn $name(
            spawner: ::embassy_executor::Spawner,
            pulse: ::ecss_can_stm32f4::Pulse,
            node: ::ecss_can::runner::Handle<$board, $node>,
        ) {
            #[::embassy_executor::task]
            fn pulses(
                pulse: ::ecss_can_stm32f4::Pulse,
                node: ::ecss_can::runner::Handle<$board, $node>,
            ) -> impl Future<Output = ()> {
                $crate::supervised(
                    "pulses",
                    pulse.run(::ecss_can::runner::TimeHandle::clock(&node), $per_second(node)),
                )
            }

            spawner.spawn(pulses(pulse, node).unwrap());
        }
    };
}
