"""Running many: jobs, records, the archive that holds them, and the driver that runs plans of them."""
