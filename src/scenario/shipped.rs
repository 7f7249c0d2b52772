//! The scenarios that come with the program, inside it.

use std::path::Path;

/// A scenario of the folder `scenarios/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shipped {
    /// The file's name without `.toml`.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

impl Shipped {
    /// The one of this name; `-` is as good as `_`.
    pub(super) fn named(name: &Path) -> Option<&'static Self> {
        let name = name.to_str()?.replace('-', "_");
        shipped().iter().find(|scenario| scenario.name == name)
    }

    /// What it shows: the first line of the file.
    pub fn shows(&self) -> &'static str {
        let line = self.text.lines().find(|line| line.starts_with("# "));
        line.unwrap_or_default().trim_start_matches("# ")
    }
}

macro_rules! files {
    ($($name:literal),* $(,)?) => { files![in "": $($name),*] };
    (in $folder:literal: $($name:literal),* $(,)?) => {
        &[$(Shipped {
            name: $name,
            text: include_str!(concat!("../../scenarios/", $folder, $name, ".toml")),
        }),*]
    };
}

/// Every shipped scenario, the smallest first.
pub fn shipped() -> &'static [Shipped] {
    files![
        "smoke",
        "open_5x5",
        "four_rooms",
        "four_rooms_slip",
        "four_rooms_random_goals",
        "holes",
        "lava_gap_7",
        "dist_shift_1",
        "dist_shift_2",
        "linked_grids",
        "two_goals",
        "rewarded_goals",
        "moving_goal",
        "centre_goal",
        "random_start",
        "u_trap",
        "u_trap_random_goals",
        "spiral",
        "one_way",
        "cliff_walking",
        "frozen_lake_4",
        "frozen_lake_8",
        "river_swim_6",
        "river_swim_20",
        "river_swim_6_continuing",
        "deep_sea_10",
        "deep_sea_stochastic_10",
        "taxi",
        "bridge_pit",
        "bridge_swamp",
        "bridge_back",
        "open_15x15",
        "open_15x15_random_goals",
        "open_15x15_turns",
        "maze_21_turns",
        "rooms_25x25",
        "rooms_25x25_slip",
        "rooms_25x25_random_goals",
        "rooms_25x25_turns",
        "rooms_50x50",
        "rooms_50x50_random_goals",
        "open_50x50",
        "open_50x50_random_goals",
        "maze_101",
        "maze_101_random_goals",
        "rooms_100x100",
        "open_100x100",
        "maze_201",
        "rooms_200x200",
    ]
}

/// The scenarios of `scenarios/report/`, which the source paper's figures 4 to 9 are made of.
pub fn report_scenarios() -> &'static [Shipped] {
    files![
        in "report/":
        "fig4_graph",
        "fig5_reward",
        "fig6_scale",
        "fig7a_two_goals",
        "fig7b_centre_goal",
        "fig8_learning",
        "fig9_linked_grids",
    ]
}
