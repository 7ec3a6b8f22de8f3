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
    let unknown = unknown(std::env::args().skip(1));
    if !unknown.is_empty() {
        return Err(ArgumentsError(format!("unknown arguments of ROS: {}", unknown.join(" "))));
    }
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

/// Arguments behind `--ros-args` that mean nothing: rcl leaves them to its callers.
fn unknown(arguments: impl IntoIterator<Item = String>) -> Vec<String> {
    const WITH_VALUE: [&str; 10] = [
        "-r",
        "--remap",
        "-p",
        "--param",
        "--params-file",
        "-e",
        "--enclave",
        "--log-level",
        "--log-config-file",
        "--log-file-name",
    ];
    const LOGS: [&str; 3] = ["rosout-logs", "stdout-logs", "external-lib-logs"];
    let is_switch = |argument: &str| {
        let log = argument.strip_prefix("--enable-").or(argument.strip_prefix("--disable-"));
        log.is_some_and(|log| LOGS.contains(&log))
    };
    let (mut unknown, mut is_ros) = (Vec::new(), false);
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--ros-args" => is_ros = true,
            "--" => is_ros = false,
            value if is_ros && WITH_VALUE.contains(&value) => drop(arguments.next()),
            switch if !is_ros || is_switch(switch) => {}
            _ => unknown.push(argument),
        }
    }
    unknown
}

/// What rcl says, without where in its sources.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    let text = text.unwrap_or("the arguments of ROS are malformed");
    text.split_once(", at /").map_or(text, |(words, _)| words).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_node_knows_is_found() {
        let of = |line: &str| unknown(line.split(' ').map(str::to_owned));
        let known = "node --ros-args -r a:=b --params-file --odd.yaml -p c:=1 --log-level debug \
                     --disable-rosout-logs -- --mine --ros-args --enable-stdout-logs -e /e";
        assert_eq!(of(known), [""; 0]);
        assert_eq!(of("--ros-args --param-file a.yaml -p b:=1 -- c"), ["--param-file", "a.yaml"]);
    }
}
