//! A node, shared by its task and its application.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::signal::Signal;

/// Holds a node for [`node_task`](super::node_task), and lets the application at it between two steps of the protocol.
pub struct NodeCell<M: RawMutex, N> {
    node: Mutex<M, RefCell<N>>,
    touched: Signal<M, ()>,
}

impl<M: RawMutex, N> NodeCell<M, N> {
    /// Takes a node before power-on.
    pub const fn new(node: N) -> Self {
        NodeCell { node: Mutex::new(RefCell::new(node)), touched: Signal::new() }
    }

    /// Looks at the node or changes it, its objects above all. The task then does at once what has become due, such as
    /// sending a PDO.
    ///
    /// # Panics
    /// When called from within itself.
    pub fn with<R>(&self, f: impl FnOnce(&mut N) -> R) -> R {
        let result = self.step(f);
        self.touched.signal(());
        result
    }

    /// As [`NodeCell::with`], of the task itself.
    pub(super) fn step<R>(&self, f: impl FnOnce(&mut N) -> R) -> R {
        self.node.lock(|node| f(&mut node.borrow_mut()))
    }

    /// Completes after the application was at the node.
    pub(super) async fn touched(&self) {
        self.touched.wait().await;
    }
}
