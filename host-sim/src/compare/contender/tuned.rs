//! What `host-sim compare --tune` printed; the order is that of [`super::gains`].

/// Bang-bang.
pub const BANG_BANG: [f64; 11] = [60.0, 0.1199, 1.289, 267.6, 6.175, 3.952, 506.2, 56.64, 1.899, 0.01, 346.5];
/// PWM with PID.
pub const PWM_PID: [f64; 14] =
    [3.221, 3.377, 1.566, 480.3, 6.825, 0.9714, 4257.0, 134.3, 0.8839, 0.006666, 0.3272, 0.3782, 11.82, 0.8159];
/// Sliding mode.
pub const SLIDING_MODE: [f64; 15] =
    [1.0, 0.3128, 0.7844, 1000.0, 10.73, 1.034, 5774.0, 118.3, 0.523, 15.52, 1.0, 0.3616, 2.631, 0.03902, 30.62];
