//! A future of an application whose result the test takes.

use std::cell::RefCell;
use std::rc::Rc;

use can_twin::wire::time::Time;
use futures_util::future::{AbortHandle, abortable};

use crate::timeline::Timeline;

/// A future of an application.
pub struct Task<T> {
    result: Rc<RefCell<Option<(Time, T)>>>,
    abort: AbortHandle,
}

impl<T: 'static> Task<T> {
    pub(crate) fn new(
        work: impl Future<Output = T> + 'static,
        timeline: Rc<Timeline>,
    ) -> (Self, impl Future<Output = ()> + 'static) {
        let result = Rc::new(RefCell::new(None));
        let (work, abort) = abortable(work);
        let place = result.clone();
        let future = async move {
            if let Ok(value) = work.await {
                *place.borrow_mut() = Some((timeline.now(), value));
            }
        };
        (Task { result, abort }, future)
    }

    /// Takes the instant of its end and its result, once.
    pub fn take(&self) -> Option<(Time, T)> {
        self.result.borrow_mut().take()
    }

    /// Drops the future.
    pub fn cancel(&self) {
        self.abort.abort();
    }
}
