"""Physical components: equations only, no knowledge of FMI, files, scenes or plots."""
