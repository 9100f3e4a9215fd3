//! Sequence tables that must not compile: `tests/compile_fail` has each with the words in which the compiler refuses it.
//! `cargo test -p compile-fail` compares. This crate has nothing else.
