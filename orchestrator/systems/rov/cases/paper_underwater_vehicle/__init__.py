"""The paper of Kabanov, Kramar and Ermakov (2021), claim by claim: six thrusters for six degrees of freedom, and the sea."""
