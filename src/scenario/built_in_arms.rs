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

/// The default agent with this potential: an actor-critic with replay, and frontier exploration.
macro_rules! replay {
    ($potential:literal $(, $more:literal)*) => {
        &[
            "agent.kind=replay-actor-critic",
            concat!("shaping.potential=", $potential),
            "exploration.kind=frontier",
            $($more),*
        ]
    };
}

/// A plain actor-critic with this potential and this exploration.
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

/// A plain actor-critic with the network's potential at four times its scale, and with a search for shorter paths to the ends seen whose
/// advice its preferences can outgrow.
macro_rules! searching_actor_critic {
    ($($more:literal),*) => {
        actor_critic!(
            "gcn",
            "frontier",
            "shaping.scale_factor=4",
            "exploration.frontier_advice=12",
            "exploration.optimism=seen-goals",
            $($more),*
        )
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
            "exploration.optimism=seen-goals",
            "agent.update=algorithm-1",
            "agent.actor_learning_rate=0.005",
            "agent.critic_learning_rate=0.01",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "report-alg2",
        "as `report`, with Algorithm 2",
        actor_critic!(
            "report",
            "none",
            "shaping.scale=raw",
            "exploration.optimism=seen-goals",
            "agent.update=algorithm-2",
            "agent.actor_learning_rate=0.01",
            "agent.critic_learning_rate=0.005",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "gcn",
        "the default: an actor-critic that replays what it has seen, shaped by the network's potential, frontier exploration",
        replay!("gcn"),
    ),
    arm(
        "gcn-shaping-only",
        "a plain actor-critic with the network's potential at four times its scale, without exploration",
        actor_critic!(
            "gcn",
            "none",
            "shaping.scale_factor=4",
            "exploration.optimism=seen-goals"
        ),
    ),
    arm(
        "no-advice",
        "the default without look-ahead advice, which it has none of unless the scenario asks for it",
        replay!("gcn", "exploration.potential_advice=0"),
    ),
    arm(
        "no-shaping",
        "the default without shaped reward: frontier exploration and replay",
        replay!("gcn", "exploration.potential_advice=0", "shaping.mix=0"),
    ),
    arm(
        "advice-only",
        "the default with look-ahead advice in the place of the shaped reward",
        replay!("gcn", "exploration.potential_advice=20", "shaping.mix=0"),
    ),
    arm(
        "look-ahead",
        "a plain actor-critic with shaped reward and look-ahead advice, frontier exploration",
        searching_actor_critic!("exploration.potential_advice=20"),
    ),
    arm(
        "actor-critic-shaped",
        "a plain actor-critic with shaped reward, without look-ahead advice, frontier exploration",
        searching_actor_critic!("exploration.potential_advice=0"),
    ),
    arm(
        "actor-critic-unshaped",
        "a plain actor-critic without shaped reward and without look-ahead advice, frontier exploration",
        searching_actor_critic!("exploration.potential_advice=0", "shaping.mix=0"),
    ),
    arm(
        "by-action",
        "the default whose search goes to the nearest untried action, wherever it may lead",
        replay!("gcn", "exploration.order=by-action"),
    ),
    arm(
        "untrained",
        "the default with a network that is never trained",
        replay!("gcn", "shaping.cold_epochs=0", "shaping.warm_epochs=0"),
    ),
    arm(
        "heat",
        "the default with one temperature in the place of a network",
        replay!("heat"),
    ),
    arm(
        "dr",
        "the default with the value in the default representation",
        replay!("dr"),
    ),
    arm(
        "sr",
        "the default with discounted visits of the goal in the successor representation",
        replay!("sr"),
    ),
    arm(
        "hops",
        "the default with the value of the learnt model's optimal policy",
        replay!("hops"),
    ),
    arm(
        "oracle",
        "the default with distance on the true map",
        replay!("oracle"),
    ),
    arm(
        "negated-oracle",
        "the default with the opposite of the oracle's potential, which leads away from the goal",
        replay!("negated-oracle"),
    ),
    arm(
        "random-potential",
        "the default with a potential drawn at random for each state",
        replay!("random"),
    ),
    arm(
        "frontier-only",
        "the default without a potential",
        replay!("none"),
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
            "exploration.frontier_advice=12",
            "exploration.potential_advice=0",
            "exploration.optimism=seen-goals",
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
            "shaping.scale_factor=4",
            "exploration.kind=none",
            "exploration.optimism=seen-goals",
        ],
    ),
];
