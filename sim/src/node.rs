//! `handover_sim node`: its arguments and help; the node itself is in `ros`.

use std::fmt::Write as _;
use std::process::ExitCode;

use handover_sim::broadcast::{Topic, parameters};

use crate::complain;

#[derive(clap::Args)]
#[command(override_usage = "handover_sim node [--ros-args [-r FROM:=TO] [-p NAME:=VALUE] \
                            [--params-file FILE]...]", after_long_help = after_help())]
pub(crate) struct Node {
    /// What ROS 2 programs understand: --ros-args and all that follows.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "--ros-args …")]
    ros: Vec<String>,
}

/// Plays until a signal ends it.
pub(crate) fn run(arguments: &Node) -> ExitCode {
    if let Some(stray) = stray(&arguments.ros) {
        return complain(
            &format!("unexpected argument '{stray}'; hint: --ros-args -p recording:=FILE"),
            2,
        );
    }
    #[cfg(feature = "ros")]
    return crate::ros::run();
    #[cfg(not(feature = "ros"))]
    complain("built without ROS 2; hint: source one and build with --features ros", 2)
}

/// The first argument that is outside of `--ros-args … --`.
fn stray(arguments: &[String]) -> Option<&str> {
    let mut is_ros = false;
    for argument in arguments {
        match argument.as_str() {
            "--ros-args" => is_ros = true,
            "--" if is_ros => is_ros = false,
            other if !is_ros => return Some(other),
            _ => {}
        }
    }
    None
}

fn after_help() -> String {
    let mut text = String::from("Topics (those of parameters that are off are not there):\n");
    for topic in Topic::ALL {
        let _ = writeln!(text, "  {:<18} {}", topic.name(), topic.type_name());
    }
    text.push_str("\nParameters, with their defaults (* may be set while it runs):\n");
    for parameter in parameters("ideal") {
        let mark = if parameter.read_only.is_none() { "*" } else { " " };
        let _ = writeln!(text, " {mark}{} = {}", parameter.name, parameter.value);
        let _ = writeln!(text, "      {}", parameter.description);
    }
    text.push_str("\ndocs/simulator.md explains them, with their ranges.");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_for_ros_is_refused() {
        let check = |arguments: &str, expected: Option<&str>| {
            let arguments: Vec<String> = arguments.split(' ').map(str::to_owned).collect();
            assert_eq!(stray(&arguments), expected);
        };
        check("--ros-args -p seed:=3 -r __node:=other", None);
        check("--ros-args -p seed:=3 -- --ros-args -p up:=z", None);
        check("recording.csv --ros-args", Some("recording.csv"));
        check("--ros-args -p seed:=3 -- --fast", Some("--fast"));
    }
}
