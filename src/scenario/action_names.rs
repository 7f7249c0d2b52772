//! What actions are called, for whoever looks at a policy.

use super::env::{Actions, EnvKind, EnvParams};

impl EnvParams {
    /// Names of the actions in the order of their numbers. None where a number means something else in every state, and none
    /// if the edge list cannot be read.
    pub fn action_names(&self) -> Vec<String> {
        let names: &[&str] = match self.kind {
            EnvKind::EdgeList => {
                let list = self.edge_list().ok().flatten();
                let names = list.iter().flat_map(|list| list.action_names());
                return names.map(str::to_owned).collect();
            }
            EnvKind::DeepSea => &[],
            EnvKind::RiverSwim => &["left", "right"],
            EnvKind::FrozenLake => &["left", "down", "right", "up"],
            EnvKind::Taxi => &["down", "up", "right", "left", "fetch", "set down"],
            EnvKind::Bridge => &["go", "side", "back"],
            _ if self.actions == Some(Actions::Turns) => &["turn left", "turn right", "forward"],
            _ => &["up", "right", "down", "left"],
        };
        names.iter().map(|&name| name.to_owned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::{Scenario, shipped};
    use std::path::Path;

    #[test]
    fn every_action_of_a_shipped_world_has_a_name() {
        for file in shipped() {
            let path = Path::new(file.name);
            let loaded = Scenario::parse(path, file.text.to_owned(), &[]).unwrap();
            let names = loaded.scenario.env.action_names();
            let is_sea = file.name.starts_with("deep_sea");
            let count = if is_sea {
                0
            } else {
                loaded.worlds.first().num_actions()
            };
            assert_eq!(names.len(), count, "{}", file.name);
        }
    }
}
