//! Nothing but a place from which the tests of laws and methods are built: see `Cargo.toml`, and `docs/contributing.md` for how to run one.
