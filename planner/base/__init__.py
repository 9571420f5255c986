"""Stands below every other room: arrays, checked values, refusals, counted work, solvers."""
