//! Tasks of a node on two buses.

/// Declares the tasks of a node, and `spawn_node`, which spawns them. Tasks of Embassy cannot be generic, so that each image has its
/// own.
///
/// `$board` is the type of its board, `$node` that of its node. The tasks are supervised under the names `bus`, twice, and `due`. The
/// image depends on `ecss-can` and `embassy-executor`.
///
/// ```ignore (a part of an image)
/// boards_runtime::node_tasks!(Board, Slave<Heater>);
///
/// // In its main task:
/// let (slave, events, runners) = RESOURCES.start(slave, board.ports, board.clock, &DIAGNOSTICS);
/// spawn_node(spawner, runners);
/// ```
#[macro_export]
macro_rules! node_tasks {
    ($board:ty, $node:ty) => {
        fn spawn_node(
            spawner: ::embassy_executor::Spawner,
            runners: ::ecss_can::runner::Runners<$board, $node>,
        ) {
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
        }
    };
}
