"""Many runs, side by side and resumable."""
