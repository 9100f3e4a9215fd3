//! Sequence tables that break a limit do not compile, and the compiler says which limit.

#[test]
fn bad_sequences_do_not_compile() {
    trybuild::TestCases::new().compile_fail("tests/compile_fail/*.rs");
}
