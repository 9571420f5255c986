"""The attitude that fits limb points best, and what is known of it beforehand."""
