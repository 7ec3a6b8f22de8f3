//! What a node is started with, taken from the command line.

use std::any::Any;
use std::panic::{catch_unwind, set_hook, take_hook};

use r2r::Context;

/// The command line cannot be meant: malformed arguments of ROS, or a parameter file that is not
/// there or none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ArgumentsError(String);

/// The process's context, with what stands behind `--ros-args`.
///
/// # Errors
/// [`ArgumentsError`] has the middleware's words.
pub fn context() -> Result<Context, ArgumentsError> {
    // r2r panics with what rcl says: bad arguments are no bug of ours, and no backtrace mends them.
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let created = catch_unwind(Context::create);
    set_hook(hook);
    match created {
        Ok(created) => created.map_err(|error| ArgumentsError(error.to_string())),
        Err(panic) => Err(ArgumentsError(words(panic.as_ref()))),
    }
}

/// What rcl says, without where in its sources.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    let text = text.unwrap_or("the arguments of ROS are malformed");
    text.split_once(", at /").map_or(text, |(words, _)| words).to_owned()
}
