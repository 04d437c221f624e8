"""Multi-agent PPO for any `jaxwalk.interfaces.Environment`: `mappo.init`, then `mappo.update` again and again."""
