"""The street behind other libraries' interfaces: Gymnasium, PettingZoo, JaxMARL (``docs/adapters.md``).

Importing this package loads none of them: ``jaxwalk.adapters.gymnasium`` and ``jaxwalk.adapters.pettingzoo`` need the
extra ``envs``; ``jaxwalk.adapters.jaxmarl`` needs nothing more.
"""
