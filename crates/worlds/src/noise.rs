//! How far the simulated robot's senses are off.
//!
//! The figures are those of the machines the models stand for, as makers and surveys state them: wheel odometry of an
//! omnidirectional base loses one to three percent of the way; a household lidar has about 1 cm; a structured-light
//! depth camera has an error that grows with the square of the depth (Khoshelham & Elberink, "Accuracy and resolution of
//! Kinect depth data", Sensors 12(2), 2012, doi:10.3390/s120201437). An instance segmenter misses an object now and then.

/// Standard deviations and rates of the noise of each sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Odometry: scale error of distances, drawn once per world.
    pub odometry_scale: f64,
    /// Odometry: scale error of turns, drawn once per world.
    pub odometry_turn_scale: f64,
    /// Odometry: position error that grows with the way, metres per square root of a metre.
    pub odometry_walk_m: f64,
    /// Odometry: heading error that grows with the way, radians per square root of a metre.
    pub odometry_walk_rad: f64,
    /// Lidar: range error, metres.
    pub lidar_m: f64,
    /// Lidar: fraction of rays that do not return.
    pub lidar_dropout: f64,
    /// Depth camera: error at one metre, metres; it grows with the square of the depth.
    pub depth_m_at_1m: f64,
    /// Depth camera: fraction of pixels without a reading.
    pub depth_dropout: f64,
    /// Segmenter: chance that an instance is missed in one frame.
    pub label_miss: f64,
    /// Segmenter: chance that a pixel of an instance is missed.
    pub label_pixel_miss: f64,
    /// Segmenter: pixels an instance must have to be found.
    pub label_pixels_min: usize,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            odometry_scale: 0.01,
            odometry_turn_scale: 0.01,
            odometry_walk_m: 0.01,
            odometry_walk_rad: 0.01,
            lidar_m: 0.01,
            lidar_dropout: 0.005,
            depth_m_at_1m: 0.002,
            depth_dropout: 0.01,
            label_miss: 0.05,
            label_pixel_miss: 0.02,
            label_pixels_min: 12,
        }
    }
}

impl Noise {
    /// Perfect senses.
    pub fn none() -> Self {
        Self {
            odometry_scale: 0.0,
            odometry_turn_scale: 0.0,
            odometry_walk_m: 0.0,
            odometry_walk_rad: 0.0,
            lidar_m: 0.0,
            lidar_dropout: 0.0,
            depth_m_at_1m: 0.0,
            depth_dropout: 0.0,
            label_miss: 0.0,
            label_pixel_miss: 0.0,
            label_pixels_min: 1,
        }
    }
}
