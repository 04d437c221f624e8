"""Multi-agent PPO for any `jaxwalk.interfaces.Environment`: call `mappo.init`, then `mappo.update` repeatedly."""
