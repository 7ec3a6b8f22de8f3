//! Nothing: the benches are the package's other targets.
