//! The arms that come with the program, as data.

/// The arm that all others are measured against.
pub const BASELINE: &str = "sparse";

/// The arm that is a scenario as it is by default.
pub const DEFAULT_ARM: &str = "gcn";

/// A name for a few settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltInArm {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// `section.key=value`.
    pub settings: &'static [&'static str],
}

const fn arm(
    name: &'static str,
    about: &'static str,
    settings: &'static [&'static str],
) -> BuiltInArm {
    BuiltInArm {
        name,
        about,
        settings,
    }
}

/// An actor-critic with this potential and this exploration.
macro_rules! actor_critic {
    ($potential:literal, $exploration:literal $(, $more:literal)*) => {
        &[
            "agent.kind=actor-critic",
            concat!("shaping.potential=", $potential),
            concat!("exploration.kind=", $exploration),
            $($more),*
        ]
    };
}

/// An actor-critic with replay, without look-ahead advice; its preferences reach as far as the advice of the search is strong.
macro_rules! replay {
    ($potential:literal) => {
        &[
            "agent.kind=replay-actor-critic",
            "agent.untried=advised",
            "agent.planning_steps=10",
            concat!("shaping.potential=", $potential),
            "exploration.kind=frontier",
            "exploration.frontier_advice=24",
            "exploration.potential_advice=0",
            "exploration.optimism=expected-return",
        ]
    };
}

/// A learner without potential and without exploration beyond its own.
macro_rules! alone {
    ($kind:literal) => {
        &[
            concat!("agent.kind=", $kind),
            "shaping.potential=none",
            "exploration.kind=none",
        ]
    };
}

/// Every built-in arm. The paper's step sizes are those of its section 4.3.
pub const BUILT_IN_ARMS: &[BuiltInArm] = &[
    arm(
        "sparse",
        "the actor-critic alone: no potential, no exploration",
        actor_critic!("none", "none"),
    ),
    arm(
        "count-bonus",
        "the actor-critic with β/√N added to its reward",
        actor_critic!("none", "count-bonus"),
    ),
    arm(
        "report",
        "the raw class probability and Algorithm 1, as the paper prints them",
        actor_critic!(
            "report",
            "none",
            "shaping.scale=raw",
            "agent.update=algorithm-1",
            "agent.actor_learning_rate=0.005",
            "agent.critic_learning_rate=0.01",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "report-alg2",
        "the same with Algorithm 2",
        actor_critic!(
            "report",
            "none",
            "shaping.scale=raw",
            "agent.update=algorithm-2",
            "agent.actor_learning_rate=0.01",
            "agent.critic_learning_rate=0.005",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "gcn",
        "the default: the network's diffusion as potential, frontier exploration",
        actor_critic!("gcn", "frontier"),
    ),
    arm(
        "gcn-shaping-only",
        "the same potential without exploration",
        actor_critic!("gcn", "none"),
    ),
    arm(
        "no-advice",
        "the default without look-ahead advice: frontier exploration and the shaped reward",
        actor_critic!("gcn", "frontier", "exploration.potential_advice=0"),
    ),
    arm(
        "no-shaping",
        "the default without shaped reward and without look-ahead advice: frontier exploration",
        actor_critic!(
            "gcn",
            "frontier",
            "exploration.potential_advice=0",
            "shaping.mix=0"
        ),
    ),
    arm(
        "advice-only",
        "the default without shaped reward: frontier exploration and look-ahead advice",
        actor_critic!("gcn", "frontier", "shaping.mix=0"),
    ),
    arm(
        "untrained",
        "the default with a network that is never trained",
        actor_critic!(
            "gcn",
            "frontier",
            "shaping.cold_epochs=0",
            "shaping.warm_epochs=0"
        ),
    ),
    arm(
        "heat",
        "a diffusion without a network, frontier exploration",
        actor_critic!("heat", "frontier"),
    ),
    arm(
        "dr",
        "the value in the default representation, frontier exploration",
        actor_critic!("dr", "frontier"),
    ),
    arm(
        "sr",
        "discounted visits of the goal in the successor representation, frontier exploration",
        actor_critic!("sr", "frontier"),
    ),
    arm(
        "hops",
        "hop distance on the visited graph, frontier exploration",
        actor_critic!("hops", "frontier"),
    ),
    arm(
        "oracle",
        "distance on the true map, frontier exploration",
        actor_critic!("oracle", "frontier"),
    ),
    arm(
        "negated-oracle",
        "the opposite of the oracle's potential, which leads away from the goal, frontier exploration",
        actor_critic!("negated-oracle", "frontier"),
    ),
    arm(
        "random-potential",
        "a potential drawn at random for each state, frontier exploration",
        actor_critic!("random", "frontier"),
    ),
    arm(
        "frontier-only",
        "frontier exploration without a potential",
        actor_critic!("none", "frontier"),
    ),
    arm(
        "replay",
        "an actor-critic that replays what it has seen with the shaping of the present potential, frontier exploration by expected return",
        replay!("gcn"),
    ),
    arm(
        "replay-unshaped",
        "the same without a potential",
        replay!("none"),
    ),
    arm(
        "replay-negated-oracle",
        "the same with the opposite of the oracle's potential",
        replay!("negated-oracle"),
    ),
    arm("q-learning", "Q-learning alone", alone!("q-learning")),
    arm("sarsa", "SARSA alone", alone!("sarsa")),
    arm(
        "dyna-q",
        "Dyna-Q with prioritised sweeping, alone",
        alone!("dyna-q"),
    ),
    arm(
        "dyna-q-plus",
        "Dyna-Q+ with a bonus for what was not tried for long, alone",
        alone!("dyna-q-plus"),
    ),
    arm(
        "planner",
        "R-max on the learnt model, alone",
        alone!("planner"),
    ),
    arm(
        "planner-frontier",
        "the planner with frontier exploration in the place of optimism",
        &[
            "agent.kind=planner",
            "agent.untried=advised",
            "shaping.potential=none",
            "exploration.kind=frontier",
            "exploration.potential_advice=0",
        ],
    ),
    arm(
        "mbie-eb",
        "MBIE-EB: plans on the learnt model with β/√n on its rewards, alone",
        alone!("mbie-eb"),
    ),
    arm(
        "ucbvi",
        "UCBVI: plans on the learnt model with confidence bounds, alone",
        alone!("ucbvi"),
    ),
    arm(
        "psrl",
        "posterior sampling: plans on a model drawn from what the world may be, alone",
        alone!("psrl"),
    ),
    arm(
        "policy-iteration",
        "policy iteration on the learnt model with the network's shaped reward",
        &[
            "agent.kind=policy-iteration",
            "shaping.potential=gcn",
            "exploration.kind=none",
        ],
    ),
];
