"""Sweeps: many trainings from one file, each with other numbers, by as many processes as share a folder."""
