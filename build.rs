//! Programs that were built with ROS from `target/ros` find its libraries without any environment.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // Without ROS nothing depends on it, so nothing is built again because of it.
    if std::env::var_os("CARGO_FEATURE_ROS").is_none() {
        return;
    }
    println!("cargo:rerun-if-env-changed=HANDOVER_RPATH");
    let folders = std::env::var("HANDOVER_RPATH").unwrap_or_default();
    let mut folders = folders.split(':').filter(|folder| !folder.is_empty()).peekable();
    if folders.peek().is_some() {
        // The old kind of path: it also counts for what the libraries need themselves.
        println!("cargo:rustc-link-arg-bins=-Wl,--disable-new-dtags");
    }
    for folder in folders {
        println!("cargo:rustc-link-arg-bins=-Wl,-rpath,{folder}");
    }
}
