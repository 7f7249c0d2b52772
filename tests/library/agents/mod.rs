//! The learners against numbers worked out by hand, value iteration, and one another.

mod experiment;
mod features;
mod learning;
mod model_based;
mod updates;
mod world;
mod yardsticks;
