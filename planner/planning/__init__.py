"""What is pointed at, and when: windows, sessions, campaigns."""
