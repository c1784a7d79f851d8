"""Corral: a dynamic set-membership filter for moving robot teams."""
