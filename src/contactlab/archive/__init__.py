"""What was run before, here and elsewhere: kept so that nothing unchanged is run twice."""
