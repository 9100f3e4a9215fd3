//! What `host-sim compare --tune` printed; the order is that of [`super::gains`].

/// Bang-bang.
pub const BANG_BANG: [f64; 11] = [10.0, 2.0, 5.0, 200.0, 12.0, 2.0, 2000.0, 60.0, 1.0, 0.3, 300.0];
/// PWM with PID.
pub const PWM_PID: [f64; 14] = [10.0, 2.0, 5.0, 200.0, 12.0, 2.0, 2000.0, 60.0, 0.1, 0.05, 0.1, 0.8, 40.0, 0.6];
/// Sliding mode.
pub const SLIDING_MODE: [f64; 15] =
    [10.0, 2.0, 5.0, 200.0, 12.0, 2.0, 2000.0, 60.0, 1.0, 20.0, 30.0, 2.0, 1.0, 0.4, 40.0];
