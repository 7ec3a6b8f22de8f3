//! `handover_node`: the robot's side of a handover as a ROS 2 node.

use std::io::Write as _;
use std::process::ExitCode;

const USAGE: &str = "\
handover_node: the robot's side of a handover as a managed ROS 2 node

Usage: handover_node [--ros-args [-r FROM:=TO] [-p NAME:=VALUE] [--params-file FILE] ...]

  -p node.model:=MODEL.safetensors   the model, as `handover learn` writes it
  -p node.autostart:=true            makes itself active; else `ros2 lifecycle set /handover configure`
                                     and `activate`, as launch/handover.launch.py does
  --params-file config/handover.yaml every parameter with its meaning, unit and range

Hears skeleton (or /tf, or skeleton_markers) and robot_skeleton; says ~/joint_targets, ~/hand_target,
~/handover_state, ~/markers and /diagnostics. Not safety-rated.
Exit codes: 0 ended as asked, 1 failed, 2 started with arguments or parameters that cannot be meant.
";

fn main() -> ExitCode {
    let first = std::env::args().nth(1);
    match first.as_deref() {
        None | Some("--ros-args") => handover_mesh::ros::run(),
        Some("-h" | "--help") => {
            // Nobody is left to tell if stdout is closed.
            let _ = std::io::stdout().write_all(USAGE.as_bytes());
            ExitCode::SUCCESS
        }
        Some(other) => {
            let _ = write!(std::io::stderr(), "error: unknown argument '{other}'\n\n{USAGE}");
            ExitCode::from(2)
        }
    }
}
