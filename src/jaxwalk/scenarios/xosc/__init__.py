"""Reads OpenSCENARIO XML as scripted tests: the part that both can say (``docs/crash-tests.md``)."""
