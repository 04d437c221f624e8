"""The street behind other libraries' interfaces (``docs/adapters.md``).

Importing this package loads none of them: ``jaxwalk.adapters.gymnasium`` and ``jaxwalk.adapters.pettingzoo`` need the
extra ``envs``, ``jaxwalk.adapters.stable_baselines3`` the extra ``frameworks``; ``jaxwalk.adapters.jaxmarl`` needs
nothing more.
"""
