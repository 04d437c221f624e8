"""Drivers not written in JAX: Python, ONNX, TorchScript, torch.export, Stable-Baselines3 (``docs/drivers.md``)."""

from jaxwalk.policies.host.driver import SECONDS, DriverError, HostDriver
from jaxwalk.policies.host.loaders import load_host_driver
from jaxwalk.policies.policy_names import is_host_driver

__all__ = ["SECONDS", "DriverError", "HostDriver", "is_host_driver", "load_host_driver"]
