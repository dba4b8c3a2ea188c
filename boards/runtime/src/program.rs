//! The task that checks the program in flash.

use embassy_executor::Spawner;

/// Spawns the task that checks the program, if this crate has the feature `program`. A part of
/// [`node_tasks`](crate::node_tasks).
#[cfg_attr(not(feature = "program"), expect(unused_variables, reason = "there is no task"))]
pub fn spawn_check(spawner: Spawner) {
    #[cfg(feature = "program")]
    spawner.spawn(check().unwrap());
}

/// Not supervised: the node works without this task, and a hanging one blocks the supervised ones.
#[cfg(feature = "program")]
#[embassy_executor::task]
async fn check() {
    ecss_can_stm32f4::check_program().await;
}
