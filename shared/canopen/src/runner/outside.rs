//! Closures that have the objects of a node and cannot use its handle.

/// Closure that has the objects of a node, and runs *outside* of its handle: every closure that is [`Send`].
///
/// While a closure has the objects, the node is lent, and a handle cannot lend it again. A
/// [`Handle`](super::Handle) is not `Send`. So a closure that captures one, or a future of one, does not compile:
///
/// ```compile_fail
/// # use async_canopen::node::DeviceNode;
/// # use async_canopen::runner::{Handle, Platform};
/// fn nested<B: Platform, N: DeviceNode>(node: Handle<B, N>) {
///     node.update(|_| node.read(|_| ()));
/// }
/// ```
///
/// Read the value first, with a call of its own, and capture the value. Other types that are not `Send`, such as `Rc`, are
/// refused as well. A handle in a thread-local variable of a program on a computer is not found: a call by it panics.
#[diagnostic::on_unimplemented(
    message = "a closure that has the objects of a node cannot use a handle",
    label = "this closure captures a handle, or something else that is not `Send`",
    note = "the node is lent while the closure runs: call the handle before or after it, and let the closure capture values"
)]
pub trait Outside {}

#[diagnostic::do_not_recommend]
impl<F: Send> Outside for F {}
