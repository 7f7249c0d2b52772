//! What guides the agent before the first reward. (owned by the engine's author)
